"""The generated modules as the book ships them, put back: needs neither git, nor omx, nor a set-up."""

import shutil

from book.setup.paths import ROOT, Stop

GENERATED = ROOT / "omx" / "generated"


def restore(generated=GENERATED):
    """Copy the shipped modules over whatever a chapter or an editor has left; the names of those that changed."""
    shipped = sorted(path for path in (generated / "shipped").glob("*.*") if path.stem != "__init__")
    if not shipped:
        raise Stop(f"{generated / 'shipped'} is empty; take this folder from a fresh copy of the book.")
    changed = []
    for path in shipped:
        target = generated / path.name
        if not target.is_file() or target.read_bytes() != path.read_bytes():
            shutil.copyfile(path, target)
            changed.append(path.name)
    return changed


def main():
    """Restore, and say what was done; the exit status."""
    changed = restore()
    print(f"restored {', '.join(changed)} in omx/generated" if changed else "omx/generated is as the book ships it")
    return 0
