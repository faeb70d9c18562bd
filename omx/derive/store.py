"""Generated modules on disk: written whole or not at all, and loaded as they are now."""

import contextlib
import importlib
import importlib.util
import os
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import ModuleType

from ..dh import DHRow
from ..errors import OmxError
from .function import Function
from .module import Parameters, script, source

GENERATED = Path(__file__).resolve().parent.parent / "generated"


def folder() -> Path:
    """Where modules are written: `omx/generated`, or the folder that OMX_GENERATED names."""
    return Path(os.environ.get("OMX_GENERATED") or GENERATED).resolve()


def write(
    name: str,
    functions: Iterable[Function],
    *,
    notebook: str,
    doc: str,
    parameters: Parameters = (),
    rows: Sequence[DHRow] = (),
    batch: bool = True,
) -> ModuleType:
    """Write `<name>.py`, and the same in JavaScript as `<name>.js`; return the former, freshly loaded.

    `parameters`: the symbols that every function takes after its inputs. A mapping gives their values too,
    and the module then carries them as `PARAMETERS`. `rows`: a DH table to carry along as `dh_rows(...)`.
    `notebook`: the name of the chapter that writes it, without folder and ending. `batch=False` leaves the
    NumPy forms out. The text depends on nothing but these arguments. Raises `BadInput` before anything is
    written, and `OmxError` where the files cannot be; what was there then stays.
    """
    about = {"notebook": notebook, "doc": doc, "parameters": parameters}
    functions = list(functions)
    path = folder() / f"{name}.py"
    texts = {
        path: source(name, functions, rows=rows, batch=batch, **about),
        path.with_suffix(".js"): script(functions, **about),
    }
    compile(texts[path], str(path), "exec")
    for target, text in texts.items():
        _store(target, text)
    return _load(name, path)


def _store(path: Path, text: str) -> None:
    """Write the file whole or not at all, and only if it changes."""
    fresh = path.with_name(f"{path.name}.{os.getpid()}.new")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists() and path.read_bytes() == text.encode():
            return
        fresh.write_text(text, encoding="utf-8", newline="\n")
        os.replace(fresh, path)
    except OSError as error:
        raise OmxError(f"cannot write {path}: {error.strerror or error}. What was there is unchanged.") from error
    finally:
        with contextlib.suppress(OSError):
            fresh.unlink(missing_ok=True)
    if path.suffix == ".py":  # bytecode of the same second and size would pass for that of the new text
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
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
