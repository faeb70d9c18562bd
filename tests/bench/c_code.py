"""The generated formulas as C: the same statements, compiled in a scratch folder and called through cffi."""

import ast
import importlib.util
import inspect
import sys
import tempfile
from pathlib import Path

HEADER = "#include <math.h>\n#define pi 3.141592653589793\n#define tau 6.283185307179586\n"
WORDS = {"max": "fmax", "min": "fmin", "abs": "fabs"}


def compiled(functions, flags=("-O3",), inputs=4):
    """`(ffi, lib)` with `name(..., out)` and `name_loop(rows, n, lengths, out)`; None where there is no compiler.

    The first `inputs` arguments of each function are a row, the others lengths.
    """
    try:
        import cffi
    except ImportError:
        return None
    ffi = cffi.FFI()
    parts = [translated(function, inputs) for function in functions]
    ffi.cdef("".join(declaration for declaration, _ in parts))
    source, libraries = HEADER + "".join(code for _, code in parts), [] if sys.platform == "win32" else ["m"]
    ffi.set_source("_omx_bench", source, extra_compile_args=list(flags), libraries=libraries)
    with tempfile.TemporaryDirectory() as folder:
        try:
            path = ffi.compile(tmpdir=folder)
        except Exception:  # no compiler, no headers: each system has its own way to say so
            return None
        spec = importlib.util.spec_from_file_location("_omx_bench", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module.ffi, module.lib


def translated(function, inputs) -> tuple[str, str]:
    """Declarations and code of one generated scalar function, and of a loop over rows of its first arguments."""
    tree = ast.parse(inspect.getsource(function)).body[0]
    body, results = [], []
    for statement in tree.body[1:]:
        if isinstance(statement, ast.Return):
            results = _leaves(statement.value, dict(_tuples(tree)))
        else:
            body += [f"double {name} = {_c(value)};" for name, value in _assignments(statement)]
    stores = [f"out[{i}] = {_c(result)};" for i, result in enumerate(results)]
    names = [argument.arg for argument in tree.args.args]
    one = f"void {tree.name}({', '.join(f'double {name}' for name in names)}, double *out)"
    loop = f"void {tree.name}_loop(const double *rows, long n, const double *lengths, double *out)"
    given = [f"rows[{inputs}*i+{k}]" for k in range(inputs)] + [f"lengths[{k}]" for k in range(len(names) - inputs)]
    call = f"{tree.name}({', '.join(given)}, out + {len(results)}*i);"
    code = f"{one} {{\n{chr(10).join(body + stores)}\n}}\n{loop} {{\nfor (long i = 0; i < n; i++) {call}\n}}\n"
    return f"{one};\n{loop};\n", code


def _tuples(tree):
    """Names that stand for tuples: results of several numbers."""
    for statement in tree.body:
        match statement:
            case ast.Assign(targets=[ast.Name(id=name)], value=ast.Tuple()):
                yield name, statement.value


def _assignments(statement):
    target, value = statement.targets[0], statement.value
    if isinstance(target, ast.Tuple):
        yield from zip((name.id for name in target.elts), value.elts, strict=True)
    elif not isinstance(value, ast.Tuple):
        yield target.id, value


def _leaves(node, tuples):
    if isinstance(node, ast.Name) and node.id in tuples:
        node = tuples[node.id]
    return [leaf for item in node.elts for leaf in _leaves(item, tuples)] if isinstance(node, ast.Tuple) else [node]


def _c(node) -> str:
    """One expression; a square is a product, and whole numbers are doubles."""
    match node:
        case ast.Name():
            return node.id
        case ast.Constant():
            return repr(float(node.value))
        case ast.UnaryOp():
            return f"(-{_c(node.operand)})"
        case ast.BinOp(op=ast.Pow()):
            return f"pow({_c(node.left)}, {_c(node.right)})"
        case ast.BinOp():
            sign = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}[type(node.op)]
            return f"({_c(node.left)} {sign} {_c(node.right)})"
        case ast.Call():
            return f"{WORDS.get(node.func.id, node.func.id)}({', '.join(_c(a) for a in node.args)})"
    raise TypeError(f"no C for {ast.dump(node)}")


def only(function, result: str):
    """A generated function cut down to one of its results: what a single branch costs."""
    tree = ast.parse(inspect.getsource(function))
    definition, wanted = tree.body[0], {result}
    kept = [ast.parse(f"return {result}").body[0]]
    for statement in reversed(definition.body[1:-1]):
        targets = {node.id for node in ast.walk(statement.targets[0]) if isinstance(node, ast.Name)}
        if targets & wanted:
            kept.append(statement)
            wanted |= {node.id for node in ast.walk(statement.value) if isinstance(node, ast.Name)}
    definition.body = kept[::-1]
    scope = dict(function.__globals__)
    exec(compile(ast.fix_missing_locations(tree), Path(inspect.getfile(function)).name, "exec"), scope)
    return scope[definition.name]
