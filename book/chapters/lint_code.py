"""Conventions for the code of a chapter, read from its syntax tree."""

import ast
import re

FORBIDDEN_MODULES = {
    "matplotlib": "figures come from omx.display.plots, which gives them units and alt text",
    "random": "use numpy.random.default_rng(seed)",
    "pickle": "pickle runs code when it is read",
    **dict.fromkeys(
        ("requests", "urllib", "http", "socket", "ftplib", "smtplib", "aiohttp", "httpx"), "chapters work offline"
    ),
    **dict.fromkeys(("subprocess", "shutil", "pty"), "chapters start no programs and touch no files"),
}
FORBIDDEN_NAMES = {
    "sleep": "nothing waits by the wall clock",
    "interact": "it hangs headless runs; use a slider and .observe",
    "interactive": "it hangs headless runs; use a slider and .observe",
    "interactive_output": "it hangs headless runs; use a slider and .observe",
    "Output": "the Output widget hangs headless runs; write to an HTML or Image widget",
    "system": "chapters start no programs",
    "popen": "chapters start no programs",
    "get_ipython": "chapters are plain Python",
}
ABSOLUTE = re.compile(r"^(/[A-Za-z]|~/|[A-Za-z]:[\\/])")


def problems(source):
    """Each problem of one code cell, as a sentence."""
    try:
        tree = ast.parse(source)
    except SyntaxError as error:
        return [f"is not plain Python (a magic, a shell command?): {error.msg}, line {error.lineno}"]
    return [problem for node in ast.walk(tree) for problem in problems_of_node(node)]


def problems_of_node(node):
    if isinstance(node, ast.Import):
        return [problem for alias in node.names for problem in problems_of_import(alias.name)]
    if isinstance(node, ast.ImportFrom):
        star = ["imports *; name what you need"] if any(alias.name == "*" for alias in node.names) else []
        return star + problems_of_import(node.module or "") + [p for a in node.names for p in problems_of_name(a.name)]
    if isinstance(node, ast.Attribute):
        return problems_of_name(node.attr) + problems_of_random(node)
    if isinstance(node, ast.Name):
        return problems_of_name(node.id)
    if isinstance(node, ast.Call) and not node.args and not node.keywords:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        return ["draws random numbers without a seed"] if name in ("default_rng", "RandomState") else []
    if isinstance(node, ast.Constant) and isinstance(node.value, str) and ABSOLUTE.match(node.value):
        return [f"holds an absolute path, {node.value!r}"]
    return []


def problems_of_import(module):
    reason = FORBIDDEN_MODULES.get(module.split(".")[0])
    return [f"imports {module}: {reason}"] if reason else []


def problems_of_name(name):
    return [f"uses {name}: {FORBIDDEN_NAMES[name]}"] if name in FORBIDDEN_NAMES else []


def problems_of_random(node):
    """`np.random.normal` and its kin share one hidden state; only generators with a seed repeat."""
    legacy = isinstance(node.value, ast.Attribute) and node.value.attr == "random"
    if legacy and node.attr not in ("default_rng", "Generator", "RandomState"):
        return [f"uses numpy.random.{node.attr}: make a generator with numpy.random.default_rng(seed)"]
    return []


def has_imports(source):
    """Does this cell import anything? Cells that do not parse are another rule's business."""
    try:
        tree = ast.parse(source)
    except SyntaxError:
        return False
    return any(isinstance(node, ast.Import | ast.ImportFrom) for node in ast.walk(tree))
