"""Of a chapter only what its module is made of: the statements that a page runs again when its reader changes a line.

A cell tagged `edit` may be changed on the page. From the statement that writes a module back to those cells, and on to
the imports, every statement is taken whose names are needed; of what stands between, the proofs too. What only shows
something stays out. Where the derivation begins with another chapter's module, that chapter comes first.
"""

import ast
import re

from book.chapters import cells, normalise
from omx.generated import CHAPTERS

WRITERS = {"write", "write_chain", "write_inverse"}
PROOF = "prove_equal"


def recipe(path):
    """The chapters to run, in order: `name`, `module` and `pieces` of each, a piece being code and, if a reader may
    change it, what it is called.

    A chapter that writes nothing has the module of its last chain written, by the name of that chain.
    """
    found = [cell for cell in normalise.read(path)["cells"] if cells.is_code(cell)]
    exercises = next((i for i, cell in enumerate(found) if "solution" in cells.tags(cell)), len(found))
    lines = [
        (number, statement, cells.source(cell))
        for number, cell in enumerate(found[:exercises])
        for statement in ast.parse(cells.source(cell)).body
    ]
    editable = {i for i, cell in enumerate(found) if "edit" in cells.tags(cell)}
    end, module, closing = _end(lines, editable)
    before, kept = _slice(lines[: end + 1], proofs=not closing)
    pieces = [*_pieces(kept, editable), *closing]
    chapters = [chapter for name in before for chapter in recipe(normalise.NOTEBOOKS / f"{CHAPTERS[name]}.ipynb")]
    return [*chapters, {"name": path.stem, "module": module, "pieces": pieces}]


def _end(lines, editable):
    """The place of the statement that writes the module, its name, and a line that writes it if there is none."""
    last = max(editable, default=0)
    writes = [
        i for i, (number, statement, _) in enumerate(lines) if number >= last and (_call(statement) or "") in WRITERS
    ]
    if writes:
        return writes[0], lines[writes[0]][1].value.args[0].value, []
    chains = [i for i, (number, statement, _) in enumerate(lines) if number in editable and _call(statement) == "Chain"]
    name = lines[chains[-1]][1].targets[0].id
    return chains[-1], name, [{"code": f'from omx.derive import write_chain\nwritten = write_chain("{name}", {name})'}]


def _call(statement):
    """The last name of the function that a statement calls for its value; None for other statements."""
    call = getattr(statement, "value", None)
    if not isinstance(call, ast.Call):
        return None
    return getattr(call.func, "attr", getattr(call.func, "id", None))


def _slice(lines, proofs):
    """The generated modules that are read, and what the last of the statements needs, with the proofs on the way.

    Of each statement: the number of its cell, its code, the source of the cell, its first and its last line there.
    """
    needed, kept, modules = set(), [], []
    for number, statement, source in reversed(lines):
        bound, changed, used = _names(statement)
        proof = proofs and isinstance(statement, ast.Expr) and _call(statement) == PROOF
        if kept and not proof and not (bound | changed) & needed:
            continue
        code = ast.get_source_segment(source, statement)
        if isinstance(statement, (ast.Import, ast.ImportFrom)):
            statement.names = [a for a in statement.names if (a.asname or a.name.split(".")[0]) in needed]
            code = ast.unparse(statement)
            if getattr(statement, "module", "") == "omx.generated":
                modules += [alias.name for alias in statement.names]
        needed = (needed - bound) | used
        kept.insert(0, (number, code, source, statement.lineno, statement.end_lineno))
    return modules, kept


def _names(statement):
    """The names that a statement gives a value, those whose value it changes, and those that it reads."""
    if isinstance(statement, (ast.Import, ast.ImportFrom)):
        return {alias.asname or alias.name.split(".")[0] for alias in statement.names}, set(), set()
    whole = isinstance(statement, (ast.Assign, ast.AnnAssign, ast.FunctionDef))
    own, stored, changed, used = set(), set(), set(), set()
    for node in ast.walk(statement):
        if isinstance(node, ast.comprehension):
            own |= {name.id for name in ast.walk(node.target) if isinstance(name, ast.Name)}
        elif isinstance(node, ast.arg):
            own.add(node.arg)
        elif isinstance(node, ast.FunctionDef):
            stored.add(node.name)
        elif isinstance(node, ast.Name):
            (stored if isinstance(node.ctx, ast.Store) else used).add(node.id)
        elif isinstance(node, (ast.Subscript, ast.Attribute)) and isinstance(node.ctx, ast.Store):
            changed |= {name.id for name in ast.walk(node.value) if isinstance(name, ast.Name)}
    if isinstance(statement, ast.AugAssign):
        used |= stored
    stored, used = stored - own, used - own
    return (stored, changed, used) if whole else (set(), stored | changed, used)


def _pieces(kept, editable):
    """Statements of one editable cell as one piece, as they stand in the chapter; all else between as another."""
    pieces = []
    for number, code, source, first, last in kept:
        name = number if number in editable else None
        if pieces and pieces[-1]["cell"] == name:
            pieces[-1]["last"], pieces[-1]["code"] = last, f"{pieces[-1]['code']}\n{code}"
        else:
            pieces.append({"cell": name, "code": code, "source": source, "first": first, "last": last})
    return [_piece(**piece) for piece in pieces]


def _piece(cell, code, source, first, last):
    if cell is None:
        return {"code": code}
    whole = "\n".join(source.splitlines()[first - 1 : last])
    name = re.findall(r"^(\w+) = ", whole, re.MULTILINE)[-1]
    return {"code": whole, "edit": name}
