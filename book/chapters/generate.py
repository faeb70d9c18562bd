"""Are the generated modules those that the notebooks write today? `python run.py generate [--check, --ship]`.

`--restore` needs none of this: see book/setup/restore.py.
"""

import difflib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from book.chapters import normalise
from book.chapters.cells import tags
from book.setup.paths import NOTEBOOKS, in_a_sentence
from omx.derive.store import GENERATED, writer
from omx.errors import OmxError

FIX = "python run.py generate"


def sources() -> dict[Path, str]:
    """Each generated module and the name of the notebook that writes it, from its header."""
    return {path: notebook for path in sorted(GENERATED.glob("*.py")) if (notebook := writer(path))}


def run_notebook(name: str, target: Path) -> None:
    """Run a chapter in a kernel of its own, its generated modules going to `target`. Raises `OmxError`."""
    import nbformat
    from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError

    from book.chapters.execute import Client

    notebook = nbformat.reads(json.dumps(normalise.read(NOTEBOOKS / f"{name}.ipynb")), as_version=4)
    notebook.cells = [
        cell for cell in notebook.cells if not {"solution", "check"} & set(tags(cell))
    ]  # a sheet's are TODO
    client = Client(notebook, timeout=120, resources={"metadata": {"path": str(NOTEBOOKS)}})
    try:
        client.run({"env": {**os.environ, "OMX_GENERATED": str(target)}, "stderr": subprocess.DEVNULL})
    except CellExecutionError as error:
        raise OmxError(f"notebooks/{name}.ipynb stops with {error.ename}: {error.evalue}") from error
    except (CellTimeoutError, DeadKernelError) as error:
        raise OmxError(f"notebooks/{name}.ipynb does not finish: {error}") from error


def chapters() -> list[str]:
    """The notebooks that write the generated modules; `OmxError` names one that is missing."""
    names = sorted(set(sources().values()))
    for name in names:
        if not (NOTEBOOKS / f"{name}.ipynb").exists():
            raise OmxError(f"{NOTEBOOKS / name}.ipynb is missing, but a generated module names it as its source.")
    return names


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


@in_a_sentence
def main(arguments: list[str]) -> int:
    """Rewrite every generated module, with --check only compare, with --ship make them what is restored later."""
    if arguments not in ([], ["--check"], ["--ship"]):
        print(f"usage: {FIX} [--check, --ship, --restore]", file=sys.stderr)
        return 2
    try:
        return _check() if arguments == ["--check"] else _write(ship=bool(arguments))
    except OmxError as error:
        print(error, file=sys.stderr)
        return 1


def _write(ship: bool) -> int:
    for name in chapters():
        print(f"running notebooks/{name}.ipynb", flush=True)
        run_notebook(name, GENERATED)
    for path in (GENERATED / "shipped").glob("*.*") if ship else ():
        if path.stem != "__init__":
            shutil.copyfile(GENERATED / path.name, path)
    return 0


def _check() -> int:
    notebooks = chapters()
    with tempfile.TemporaryDirectory() as folder:
        for name in notebooks:
            run_notebook(name, Path(folder))
        found = difference(Path(folder))
    if found:
        print(f"{found}\nThe generated modules are not those that the notebooks write. To write them: {FIX}")
        return 1
    print(f"{len(sources())} generated modules are what {', '.join(notebooks)} write.")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
