"""Are the generated modules those that the notebooks write today? `python -m omx.codegen [--check]`."""

import difflib
import os
import sys
import tempfile
from pathlib import Path

from ..errors import OmxError
from .module import MARK
from .store import GENERATED

NOTEBOOKS = GENERATED.parent.parent / "notebooks"
FIX = "python -m omx.codegen"


def sources() -> dict[Path, str]:
    """Each generated module and the name of the notebook that writes it, from its header."""
    found = {}
    for path in sorted(GENERATED.glob("*.py")):
        for line in path.read_text(encoding="utf-8").splitlines():
            if line.startswith(MARK):
                found[path] = line[len(MARK) :].split(".ipynb")[0]
                break
    return found


def run_notebook(name: str, target: Path) -> None:
    """Run a chapter in a kernel of its own, its generated modules going to `target`. Raises `OmxError`."""
    import nbformat
    from nbclient import NotebookClient
    from nbclient.exceptions import CellExecutionError

    path = NOTEBOOKS / f"{name}.ipynb"
    if not path.exists():
        raise OmxError(f"{path} is missing; the generated modules can only be checked in a clone of the book.")
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(NOTEBOOKS)}})
    try:
        client.execute(env={**os.environ, "OMX_GENERATED": str(target)})
    except CellExecutionError as error:
        raise OmxError(f"notebooks/{name}.ipynb stops with {error.ename}: {error.evalue}") from error


def files(folder: Path) -> dict[str, Path]:
    """The Python and JavaScript modules in a folder, by name."""
    return {path.name: path for path in folder.iterdir() if path.suffix in (".py", ".js") and path.stem != "__init__"}


def difference(target: Path) -> str:
    """A diff of the checked-in modules against those in `target`; empty if names and bytes are the same."""
    ours, theirs = files(GENERATED), files(target)
    pieces = []
    for name in sorted(ours.keys() | theirs.keys()):
        old, new = (side[name].read_bytes().decode() if name in side else "" for side in (ours, theirs))
        lines = (old.splitlines(keepends=True), new.splitlines(keepends=True))
        pieces += difflib.unified_diff(*lines, f"checked in/{name}", f"notebook/{name}")
    return "".join(pieces)


def main(arguments: list[str]) -> int:
    """Rewrite every generated module, or with --check only compare; the exit status."""
    if arguments not in ([], ["--check"]):
        print(f"usage: {FIX} [--check]", file=sys.stderr)
        return 2
    try:
        return _check() if arguments else _write()
    except OmxError as error:
        print(error, file=sys.stderr)
        return 1


def _write() -> int:
    for name in sorted(set(sources().values())):
        print(f"running notebooks/{name}.ipynb", flush=True)
        run_notebook(name, GENERATED)
    return 0


def _check() -> int:
    notebooks = sorted(set(sources().values()))
    with tempfile.TemporaryDirectory() as folder:
        for name in notebooks:
            run_notebook(name, Path(folder))
        found = difference(Path(folder))
    if found:
        print(f"{found}\nThe generated modules are not those that the notebooks write. To write them: {FIX}")
        return 1
    print(f"{len(sources())} generated modules are what {', '.join(notebooks)} write.")
    return 0
