"""Generated modules on disk: written both or neither, and loaded as they are now."""

import contextlib
import importlib
import importlib.util
import os
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from ..arrays import shown
from ..dh import DHRow
from ..errors import BadInput, OmxError
from ..generated import CHAPTERS
from .function import Function
from .module import MARK, SCRATCH, Parameters, listed, parameter_values, script, source, table_of

GENERATED = Path(__file__).resolve().parent.parent / "generated"


def place(name: str, notebook: str | None, folder: str | os.PathLike | None = None) -> Path:
    """The folder in which a module is written: `folder`, else where OMX_GENERATED says, if it says anything.

    Else what the small module is made of goes to `omx/generated`, and all other modules to the current folder, which
    is the notebook's.
    """
    if folder is None:
        folder = os.environ.get("OMX_GENERATED") or (GENERATED if name in CHAPTERS and notebook else ".")
    if not isinstance(folder, (str, os.PathLike)) or not str(folder):
        raise BadInput(f"`folder` must be the path of a folder; got {shown(folder)}.")
    return Path(folder).resolve()


def write(
    name: str,
    functions: Iterable[Function],
    *,
    doc: str,
    notebook: str | None = None,
    folder: str | os.PathLike | None = None,
    parameters: Parameters = (),
    rows: Sequence[DHRow] = (),
    branches: Sequence[str] = (),
    batch: bool = True,
) -> ModuleType:
    """Write `<name>.py`, and the same in JavaScript as `<name>.js`; return the former, freshly loaded.

    The text depends on nothing but these arguments. Raises `BadInput` before anything is written, also for a file
    that another chapter, or you, have written by this name; and `OmxError` where the files cannot be written. What was
    there then stays, both files of it.

    Args:
        name: of the module.
        functions: what it holds.
        doc: a sentence that says what it is.
        notebook: the name of the chapter that writes it, without folder and ending; none for an arm of your own.
        folder: where to; the notebook's folder if left out, `omx/generated` for the chapters of the book.
        parameters: the symbols that every function takes after its inputs. A mapping gives their values too, and the
            module then carries them as `PARAMETERS`.
        rows: a DH table to carry along as `dh_rows(...)`.
        branches: the names of an inverse's branches, to carry along as `BRANCHES`.
        batch: False leaves the NumPy forms out.
    """
    functions, rows = listed(functions), table_of(rows)
    about: dict[str, Any] = {"notebook": notebook, "doc": doc, "parameters": parameters, "branches": branches}
    python = source(name, functions, rows=rows, batch=batch, **about)
    javascript = script(functions, **about)
    path = place(name, notebook, folder) / f"{name}.py"
    _refuse_what_is_not_ours(path, notebook)
    compile(python, str(path), "exec")
    if name in CHAPTERS:
        _refuse_no_arm(parameters)
    _store({path: python, path.with_suffix(".js"): javascript})
    return _load(name, path)


def writer(path: Path) -> str | None:
    """The notebook that wrote a generated module, by its header; "" for a scratch module, None for any other file."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None
    for line in text.splitlines():
        if line.startswith(MARK):
            return line[len(MARK) :].split(".ipynb")[0]
        if line == SCRATCH:
            return ""
    return None


def _refuse_what_is_not_ours(path: Path, notebook: str | None) -> None:
    """`BadInput` where `path` is another chapter's module, a file of the reader's, or a name that Python uses."""
    if path.parent == GENERATED and path.stem in CHAPTERS:
        owner: str | None = CHAPTERS[path.stem]
    elif path.exists() and path.stat().st_size:
        owner = writer(path)
        if owner is None:
            raise BadInput(f"{path} is there, and no notebook has written it; choose another name.")
    elif path.parent == GENERATED:
        raise BadInput(f"`{path.stem}` is no part of the small module; give a `folder` for it.")
    elif path.stem in sys.stdlib_module_names or path.stem in ("numpy", "sympy", "omx"):
        raise BadInput(f"`{path.stem}` is a module that Python or the book itself imports; choose another name.")
    else:
        return
    if owner != (notebook or ""):
        whose = f"notebooks/{owner}.ipynb" if owner else "an arm of your own"
        raise BadInput(f"`{path.stem}` is the module of {whose}; choose another name, or another `folder`.")


def _refuse_no_arm(parameters: Parameters) -> None:
    """`BadInput` for lengths that would leave `import omx` without an arm."""
    values = parameter_values(parameters)
    short = [f"{symbol} = {value}" for symbol, value in values.items() if str(symbol)[0] == "L" and not value > 0]
    if short:
        raise BadInput(f"{', '.join(short)} mm makes no arm: every length must be more than 0. Nothing was written.")


def _store(texts: dict[Path, str]) -> None:
    """Write all files or none, each only if it changes."""
    fresh, old = {}, {}
    try:
        for path, text in texts.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            old[path] = path.read_bytes() if path.exists() else None
            if old[path] != text.encode():
                fresh[path] = path.with_name(f"{path.name}.{os.getpid()}.new")
                fresh[path].write_text(text, encoding="utf-8", newline="\n")
        for path, new in fresh.items():
            os.replace(new, path)
            _forget_bytecode(path)
    except OSError as error:
        for touched in fresh:
            _put_back(touched, old[touched])
        raise OmxError(f"cannot write {path}: {error.strerror or error}. What was there is unchanged.") from error
    finally:
        for new in fresh.values():
            with contextlib.suppress(OSError):
                new.unlink(missing_ok=True)


def _put_back(path: Path, content: bytes | None) -> None:
    with contextlib.suppress(OSError):
        if content is None:
            path.unlink(missing_ok=True)
        elif path.read_bytes() != content:
            path.write_bytes(content)
            _forget_bytecode(path)


def _forget_bytecode(path: Path) -> None:
    """Bytecode of the same second and size would pass for that of the new text."""
    if path.suffix == ".py":
        Path(importlib.util.cache_from_source(str(path))).unlink(missing_ok=True)


def _load(name: str, path: Path) -> ModuleType:
    """The module as it is on disk now; inside the package it also replaces the copy loaded earlier."""
    if path.parent == GENERATED:
        importlib.invalidate_caches()
        qualified = f"omx.generated.{name}"
        if qualified in sys.modules:
            return importlib.reload(sys.modules[qualified])
        return importlib.import_module(qualified)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
