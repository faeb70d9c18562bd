"""The reader's folder `work/`: copies of the chapters without solutions, which no command of ours overwrites.

    python run.py update [FOLDER]    new editions come in and answers stay; FOLDER: another copy of the book
    python run.py reset 03           the chapter as it was given out; yours is kept in work/earlier

Beside each copy `work/.given` holds what was given out, so that what the reader changed is known.
"""

import shutil
import sys
from pathlib import Path

from book.chapters import normalise
from book.chapters.cells import is_code, is_note, source, tags
from book.chapters.student import Refused, student_copy
from book.reader import merge, overview
from book.setup import names
from book.setup.file_lock import one_at_a_time
from book.setup.paths import ENVIRONMENT, ROOT, WORK, Stop, in_a_sentence
from book.setup.update import earlier

GIVEN = ".given"


def edition(path):
    """The copy of a chapter that a reader gets: no solutions, outputs or speaker's notes; the way to its neighbours."""
    notebook = normalise.read(path)
    is_copy = any("solution" in tags(cell) for cell in notebook["cells"]) and all(
        "TODO" in source(cell) for cell in notebook["cells"] if "solution" in tags(cell) and is_code(cell)
    )
    try:
        copied = normalise.normalise(notebook) if is_copy else student_copy(notebook)
    except Refused as reason:
        raise Stop(f"{path.name} cannot be given to readers: {reason}") from reason
    cells = [cell for cell in copied["cells"] if not is_note(cell)]
    before, after = overview.links(path)
    return {**copied, "cells": [before, *cells, after]}


def prepare(folder=WORK):
    """Give out what is not there yet, bring copies that nobody changed up to date; the names that wait for `update`."""
    waiting = []
    for path in names.chapters():
        follow(path.name, folder)
        fresh, target, given = edition(path), folder / path.name, folder / GIVEN / path.name
        was, mine = read(given), read(target)
        if target.exists() and mine is None:
            continue  # damaged: theirs, whatever it is; Jupyter says what is wrong with it
        if mine is None or (was is not None and not merge.changed(mine, was)):
            give(fresh if mine is None else merge.merged(mine, was, fresh), fresh, target, given)
        elif was != fresh:
            waiting.append(path.name)
    overview.write(folder)
    return waiting


def follow(name, folder):
    """Let a copy whose chapter has another number now have its new name."""
    others = [path for path in folder.glob(f"[0-9][0-9]{name[2:]}") if not (normalise.NOTEBOOKS / path.name).exists()]
    if len(others) == 1 and not (folder / name).exists():
        for kept in (folder, folder / GIVEN):
            if (kept / others[0].name).exists():
                (kept / others[0].name).rename(kept / name)


def carry_over(folder=WORK):
    """Bring every copy up to date, answers kept, and say what was done."""
    for name in prepare(folder):
        target, given = folder / name, folder / GIVEN / name
        mine, fresh = read(target), edition(normalise.NOTEBOOKS / name)
        was = read(given) or fresh
        if not merge.by_id(mine).keys() & merge.by_id(was).keys():
            print(f"{name}: its cells have lost their ids, so nothing can be carried over; `reset {name[:2]}` gives "
                  "the new edition and keeps yours.")  # fmt: skip
            continue
        kept = keep(target, folder)
        give(merge.merged(mine, was, fresh), fresh, target, given)
        print(f"{name}: the new edition, with what you wrote; as it was before: {shown(kept)}")
    print(f"The chapters in {shown(folder)} are up to date.")


def take_along(old, folder=WORK):
    """Copy the work of another copy of the book; what both hold stays here, and the other goes to work/earlier."""
    source = Path(old, "work") if Path(old, "work").is_dir() else Path(old)
    if not (source / GIVEN).is_dir():
        raise Stop(f"{old} holds no folder `work` of this book.")
    if folder.exists() and source.samefile(folder):
        raise Stop(f"{old} is this copy of the book itself; name the folder of the other one.")
    for path in sorted(path for path in source.rglob("*") if path.is_file() and GIVEN not in path.parts):
        target = folder / path.relative_to(source)
        given, was = folder / GIVEN / target.name, read(folder / GIVEN / target.name)
        mine = read(target)
        if target.exists() and (was is None or mine is None or merge.changed(mine, was)):
            if target.read_bytes() != path.read_bytes():
                print(f"{shown(target)} is changed here, too; the other is {shown(keep(path, folder))}")
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(path, target)
        if (source / GIVEN / path.name).exists():
            given.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source / GIVEN / path.name, given)


def reset(name, folder=WORK):
    """Give a chapter out again; the reader's version is kept if they changed it."""
    path = names.chapter(name, folder)
    source = normalise.NOTEBOOKS / path.name
    if path.parent != folder or not source.exists():
        raise Stop(f"{name!r} is no chapter in {shown(folder)}.")
    fresh, given, mine = edition(source), folder / GIVEN / path.name, read(path)
    if path.exists() and (mine is None or read(given) is None or merge.changed(mine, read(given))):
        print(f"Yours is kept: {shown(keep(path, folder))}")
    from omx.check import passed

    passed.forget(path)
    give(fresh, fresh, path, given)
    print(f"{shown(path)} is as it was given out.")


def give(notebook, fresh, target, given):
    """Write a copy, and first what is given out with it."""
    given.parent.mkdir(parents=True, exist_ok=True)
    normalise.write(given, fresh)
    normalise.write(target, notebook)


def keep(path, folder):
    """A copy of the file in the folder's `earlier`; its path."""
    kept = earlier(path.name, folder)
    shutil.copy2(path, kept)
    return kept


def read(path):
    """The notebook, or None where there is none that can be read."""
    try:
        return normalise.read(path)
    except (OSError, normalise.Damaged):
        return None


def shown(path):
    """A path as a reader knows it: from the book's folder on."""
    return path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else str(path)


@in_a_sentence
def main(argv):
    if argv == ["reset"]:
        raise Stop("Which chapter? For example: python run.py reset 03")
    words = [word for word in argv[1:] if word != "--carry-over"]
    with one_at_a_time(ENVIRONMENT):  # another terminal may do the same
        for word in words:
            (reset if argv[0] == "reset" else take_along)(word)
        if argv[0] != "reset":
            carry_over()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
