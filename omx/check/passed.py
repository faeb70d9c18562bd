"""Which exercises a reader has done: kept in one small file beside the notebooks, and counted in the contents."""

import json
import os
from pathlib import Path

FILE = ".progress.json"
NAME = "the reader's name"


def progress(folder: str | os.PathLike = ".") -> dict[Path, list[bool]]:
    """Each notebook of `folder` that has exercises: is each done? All its checks must have passed, and passed last."""
    stored = _stored(folder)
    found = {path: [_done(checks, stored) for checks in exercises(path)] for path in _notebooks(folder)}
    return {path: done for path, done in found.items() if done}


def _notebooks(folder) -> list[Path]:
    return sorted(Path(folder).glob("*.ipynb"))


def _done(checks: tuple[str, ...], stored: dict) -> bool:
    return all(stored.get(check) is True for check in checks)


def record(cell: str, passed: bool, folder: str | os.PathLike = ".") -> str:
    """Keep whether the check in `cell` passed; "2 of 4 exercises of this chapter done", '' if it is of no chapter."""
    stored = _stored(folder)
    if stored.get(cell) != passed:
        stored[cell] = passed
        _store(folder, stored)
    for path in _notebooks(folder):
        found = exercises(path)
        if any(cell in checks for checks in found):
            return f"{sum(_done(checks, stored) for checks in found)} of {len(found)} exercises of this chapter done."
    return ""


def forget(path: Path) -> None:
    """Forget which checks of a notebook have passed: it is given out anew."""
    stored, checks = _stored(path.parent), {check for checks in exercises(path) for check in checks}
    if checks & stored.keys():
        _store(path.parent, {cell: passed for cell, passed in stored.items() if cell not in checks})


def keep_name(name: str, folder: str | os.PathLike = ".") -> None:
    """Keep the reader's name beside the progress."""
    _store(folder, {**_stored(folder), NAME: name})


def name(folder: str | os.PathLike = ".") -> str:
    """The name that the reader gave, or ''."""
    found = _stored(folder).get(NAME, "")
    return found if isinstance(found, str) else ""


def exercises(path: Path) -> list[tuple[str, ...]]:
    """The exercises of a notebook, each by the ids of its checks; none of a file that is no notebook."""
    try:
        cells = json.loads(path.read_text(encoding="utf-8-sig"))["cells"]
        tagged = [(cell.get("id", ""), cell["metadata"].get("tags", [])) for cell in cells]
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return []
    found: list[tuple[str, ...]] = []
    for name, tags in tagged:
        if "exercise" in tags:
            found.append(())
        elif "check" in tags:
            checks = found.pop() if found else ()
            found.append((*checks, name))
    return [checks for checks in found if checks]  # an answer in words has none


def _stored(folder) -> dict:
    try:
        stored = json.loads(Path(folder, FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stored if isinstance(stored, dict) else {}


def _store(folder, stored: dict) -> None:
    """Write the file whole, or leave it: a full or read-only disk must not stop a reader."""
    partial = Path(folder, f"{FILE}.{os.getpid()}")
    try:
        partial.write_text(json.dumps(stored, indent=1, sort_keys=True) + "\n", encoding="utf-8")
        os.replace(partial, Path(folder, FILE))
    except OSError:
        pass
