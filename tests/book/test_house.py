"""House rules that a machine can check, over every file of the repository."""

import ast
import os
import pkgutil
import re
import subprocess
import sys
import textwrap
import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from book.setup import lock
from book.setup.paths import ROOT

FOLDERS = {".binder", ".ci", ".devcontainer", ".github", "book", "notebooks", "omx", "tests"}
ROOT_FILES = {
    *(".gitattributes", ".gitignore", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "README.md"),
    *("environment.txt", "pyproject.toml", "run.py"),
}
MADE = {".git", ".venv", ".pytest_cache", ".ruff_cache", ".hypothesis", ".ipynb_checkpoints", "__pycache__"}
MADE |= {"build", "node_modules", ".virtual_documents", ".DS_Store", ".jupyter_cache"}
TEXT = {".py", ".md", ".txt", ".toml", ".ipynb", ".yml", ".yaml", ".css", ".js", ".html", ".json", ".cfg", ".sh", ""}


def is_made(path):
    parts = path.relative_to(ROOT).parts
    return bool(MADE & set(parts)) or any(part.endswith(".egg-info") for part in parts)


def files():
    """Every file that belongs to the repository, whether or not there is a git to ask; what is made is not entered."""
    found = []
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [name for name in folders if not is_made(Path(folder, name))]
        found += [path for name in names if (path := Path(folder, name)).is_file() and not is_made(path)]
    return sorted(found)


TEXTS = [path for path in files() if path.suffix in TEXT and path.name != "package-lock.json"]


def findings(pattern, paths):
    """`file:line: text` for each line that matches, this file's own patterns aside."""
    for path in paths:
        if path != Path(__file__):
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                if pattern.search(line):
                    yield f"{path.relative_to(ROOT)}:{number}: {line.strip()[:120]}"


RULES = {
    "no content networks or web fonts": r"\b(unpkg\.com|jsdelivr|cdnjs|cdn\.|googleapis|gstatic|esm\.sh|skypack)\b",
    "no host names of registries": r"\b(pypi\.org|pythonhosted\.org|npmjs\.(org|com)|anaconda\.org)\b",
    "no absolute paths": r"(?<![\w.:/~*<>)\]-])/(home|root|work|Users|mnt|opt)/\w",
    "no pickle": r"^\s*(import|from) (pickle|dill|cloudpickle|joblib|shelve)\b",
    "no server on every address": r"['\"](0\.0\.0\.0|::)['\"]",
    "no loose ends": r"\b(FIXME|XXX|HACK)\b",
    "no references to a tracker": r"\b(issue|ticket) #?\d+\b",
}


@pytest.mark.parametrize("rule", RULES)
def test_rule(rule):
    found = list(findings(re.compile(RULES[rule]), TEXTS))
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    ("rule", "line"),
    [
        ("no content networks or web fonts", "<script src='https://unpkg.com/three'>"),
        ("no host names of registries", "--index-url https://pypi.org/simple"),
        ("no absolute paths", "cd /home/someone/book"),
        ("no pickle", "    import pickle"),
        ("no server on every address", "bind('0.0.0.0', 80)"),
        ("no loose ends", "# FIXME later"),
        ("no references to a tracker", "see issue 12"),
    ],
)
def test_rule_can_fail(rule, line):
    assert re.search(RULES[rule], line)


def test_only_exercises_say_todo():
    paths = [path for path in TEXTS if path.suffix == ".py" and not {"tests", "chapters", "check"} & set(path.parts)]
    found = list(findings(re.compile(r"#.*\bTODO\b"), paths))
    assert not found, "\n".join(found)


def test_the_root_holds_five_folders_and_known_files():
    entries = [path for path in ROOT.iterdir() if not is_made(path)]
    assert {path.name for path in entries if path.is_dir()} <= FOLDERS
    assert {path.name for path in entries if path.is_file()} <= ROOT_FILES


def test_notebooks_holds_chapters_and_nothing_else():
    strangers = [path.name for path in (ROOT / "notebooks").iterdir() if not is_made(path)]
    strangers = [name for name in strangers if not re.fullmatch(r"\d\d-[a-z0-9-]+\.ipynb", name)]
    assert not strangers


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"])
def test_links_of_the_front_pages_lead_somewhere(name):
    targets = re.findall(r"\]\(([^)#\s]+)", (ROOT / name).read_text(encoding="utf-8"))
    lost = [target for target in targets if not re.match(r"[a-z]+:", target) and not (ROOT / target).exists()]
    assert not lost


def test_the_readme_shows_what_a_chapter_writes_and_code_that_runs():
    shown = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.S)
    written = (ROOT / "omx/generated/shipped/fk.py").read_text(encoding="utf-8")
    assert textwrap.indent(shown[0], "    ").replace(" * ", "*") in written
    assert subprocess.run([sys.executable, "-c", shown[1]], cwd=ROOT, check=False).returncode == 0


# ---- versions live in environment.txt ------------------------------------------------------------------

UPPER, LOWER = lock.halves((ROOT / "environment.txt").read_text(encoding="utf-8"))
REQUIREMENTS = [line for line in UPPER + LOWER if lock.package_of(line)]


def test_every_requirement_is_pinned():
    loose = [line for line in REQUIREMENTS if not re.match(r"[\w.-]+==[\w.]+(\s|$)", line)]
    assert not loose


def test_no_package_is_pinned_by_hand_and_by_lock():
    upper = [lock.package_of(line) for line in UPPER if lock.package_of(line)]
    assert len(upper) == len(set(upper))
    assert not set(upper) & {lock.package_of(line) for line in LOWER}


def test_versions_are_nowhere_else():
    pattern = re.compile(r"\b({})\s*(==|~=|>=)\s*\d".format("|".join(map(lock.package_of, REQUIREMENTS))))
    paths = [path for path in TEXTS if path.suffix in (".py", ".toml", ".yml", ".sh", "") and "tests" not in path.parts]
    found = list(findings(pattern, paths))
    assert not found, "\n".join(found)


def test_jupyter_starts_without_the_parsers_that_nobody_asks():
    told = "import nbformat, sys; print('jsonschema' in sys.modules, 'lark' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "False"]


def test_all_that_is_pinned_is_installed_as_pinned():
    from importlib.metadata import version

    import packaging.requirements

    for line in REQUIREMENTS:
        wanted = packaging.requirements.Requirement(line.split("  #")[0])
        if wanted.marker is None or wanted.marker.evaluate():
            assert wanted.specifier.contains(version(wanted.name)), f"{line}, installed: {version(wanted.name)}"


API = [
    (page.name, *found)
    for page in sorted((ROOT / "book/api").glob("*.md"))
    for found in re.findall(r"auto\w+:: ([\w.]+)(?:\n +:members: (.+))?", page.read_text(encoding="utf-8"))
]


@pytest.mark.parametrize(("page", "name", "members"), API)
def test_the_pages_of_the_api_name_what_is_there(page, name, members):
    """So does the site's build, minutes later."""
    found = pkgutil.resolve_name(name)
    for member in filter(None, map(str.strip, members.split(","))):
        getattr(found, member)


def test_ruff_has_nothing_to_say():
    command = [sys.executable, "-m", "ruff", "check", "--no-cache", "--output-format=concise", "."]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_an_installed_omx_has_all_of_its_files():
    """What the browser's Python, a wheel, gets: no script or style of the package is left behind."""
    packed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["package-data"]
    left = [path for path in files() if ROOT / "omx" in path.parents and path.suffix != ".py"]
    assert left
    assert [path for path in left if not any(path.match(pattern) for pattern in packed["*"])] == []


# ---- the rooms of the book ----

#: Room -> the rooms that it may import from; `omx` is one of them. CONTRIBUTING.md says what lives there.
ROOMS = {
    "setup": set(), "chapters": {"setup", "omx"}, "grading": {"setup", "chapters"},
    "publish": {"setup", "chapters", "omx"}, "reader": {"setup", "chapters", "publish", "omx"},
    "conf": {"publish"},
}  # fmt: skip
MODULES = {".".join(p.relative_to(ROOT).with_suffix("").parts): p for p in sorted((ROOT / "book").rglob("*.py"))}


def imports(path):
    """The modules of `omx` and of the book that a file imports, also inside functions."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: say it with its whole name"
            inner = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from (name if name in MODULES else node.module for name in inner)


def room(name):
    first, *rest = name.split(".")
    return rest[0] if first == "book" and rest else first


def test_rooms_of_the_book_import_what_they_may_and_never_in_a_circle():
    graph = {name: {t for t in imports(path) if t in MODULES} - {name} for name, path in MODULES.items()}
    for name, path in MODULES.items():
        ours = {room(target) for target in imports(path) if target.split(".")[0] in ("book", "omx")} - {"book"}
        assert ours <= {room(name)} | ROOMS.get(room(name), set()), f"{name} imports from {sorted(ours)}"
    setup = {
        target.split(".")[0] for name, path in MODULES.items() if room(name) == "setup" for target in imports(path)
    }
    assert setup <= sys.stdlib_module_names | {"book"}
    TopologicalSorter(graph).prepare()
