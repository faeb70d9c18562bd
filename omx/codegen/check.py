"""Are the generated modules those that the notebooks write today? `python -m omx.codegen [--check]`."""

import difflib
import os
import sys
import tempfile
from pathlib import Path

from ..errors import OmxError
from .module import GENERATED, MARK

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
    """Run a chapter in a kernel of its own, its generated modules going to `target`."""
    import nbformat
    from nbclient import NotebookClient

    path = NOTEBOOKS / f"{name}.ipynb"
    if not path.exists():
        raise OmxError(f"{path} is missing; the generated modules can only be checked in a clone of the book.")
    notebook = nbformat.read(path, as_version=4)
    before = os.environ.get("OMX_GENERATED")
    os.environ["OMX_GENERATED"] = str(target)
    try:
        NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(NOTEBOOKS)}}).execute()
    finally:
        os.environ.pop("OMX_GENERATED") if before is None else os.environ.update(OMX_GENERATED=before)


def difference(target: Path) -> str:
    """A diff of the checked-in modules against those in `target`; empty if names and bytes are the same."""
    ours = {path.name: path for path in sources()}
    theirs = {path.name: path for path in target.glob("*.py")}
    pieces = []
    for name in sorted(ours.keys() | theirs.keys()):
        old = ours[name].read_bytes().decode() if name in ours else ""
        new = theirs[name].read_bytes().decode() if name in theirs else ""
        pieces += difflib.unified_diff(
            old.splitlines(keepends=True), new.splitlines(keepends=True), f"checked in/{name}", f"notebook/{name}"
        )
    return "".join(pieces)


def main(arguments: list[str]) -> int:
    """Rewrite every generated module, or with --check only compare; the exit status."""
    if arguments not in ([], ["--check"]):
        print(f"usage: {FIX} [--check]", file=sys.stderr)
        return 2
    notebooks = sorted(set(sources().values()))
    if not arguments:
        for name in notebooks:
            print(f"running notebooks/{name}.ipynb")
            run_notebook(name, GENERATED)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        for name in notebooks:
            run_notebook(name, Path(folder))
        found = difference(Path(folder))
    if found:
        print(f"{found}\nThe generated modules are not those that the notebooks write. To write them: {FIX}")
        return 1
    print(f"{len(sources())} generated modules are what {', '.join(notebooks)} write.")
    return 0
