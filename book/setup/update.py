"""Bring in a new edition of the book with git; what the reader changed is put aside. Standard library only."""

import os
import shutil
import subprocess
import sys

from book.setup.paths import ROOT, WORK, Stop

#: What a reader changes without meaning to: by running the sources, or chapter 03 with an arm of their own.
OURS = ("notebooks/", "omx/generated/")


def pull():
    """Fetch and fast-forward a checkout; what the new edition would overwrite is moved to work/earlier first."""
    top = git("rev-parse", "--show-toplevel")
    if top is None or not os.path.samefile(top.strip(), ROOT):
        why = ("git cannot read this checkout: it is not installed, or the folder is somebody else's"
               if (ROOT / ".git").exists() else "This folder is no git checkout")  # fmt: skip
        print(f"{why}, so nothing was fetched. To take answers along from an older copy of the book: python run.py "
              "update FOLDER")  # fmt: skip
        return
    if git("rev-parse", "--abbrev-ref", "@{upstream}") is None:
        print("This checkout follows no other repository, so nothing was fetched.")
        return
    must("fetch", "--quiet")
    incoming = names("HEAD...@{upstream}")
    if not incoming:
        print("This is the newest edition.")
        return
    if git("merge-base", "--is-ancestor", "HEAD", "@{upstream}") is None:
        raise Stop("You have commits of your own here: bring the new edition in with `git pull --rebase`.")
    in_the_way = [name for name in names("HEAD") if name in incoming]
    if others := [name for name in in_the_way if not name.startswith(OURS)]:
        raise Stop(f"You changed {', '.join(others[:5])}: commit that or put it elsewhere, then type the same again.")
    put_aside(in_the_way)
    must("merge", "--quiet", "--ff-only", "@{upstream}")
    print(f"A new edition is here: {len(incoming)} files are new or changed. If JupyterLab is open, start it again.")


def names(what):
    """The files that differ, as `git diff` understands it."""
    return [name for name in (git("diff", "--name-only", "-z", what) or "").split("\0") if name]


def must(*arguments):
    """Run git. Raises `Stop` with its last words."""
    done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        last = (done.stderr or done.stdout).strip().splitlines() or ["it said nothing"]
        raise Stop(f"git could not bring in the new edition ({last[-1][:200]}); nothing of yours was changed.")


def put_aside(names):
    """Keep a copy of each file in work/earlier, then give it the form that it had."""
    for name in names:
        path = ROOT / name
        if path.exists():
            kept = earlier(path.name)
            shutil.copy2(path, kept)
            print(f"{name} was changed here: yours is kept as {kept.relative_to(ROOT).as_posix()}.")
        if git("checkout", "HEAD", "--", name) is None:
            raise Stop(f"git could not restore {name}; your version is kept in work/earlier.")


def earlier(name, work=WORK):
    """A path in work/earlier for a file of this name, not yet taken."""
    folder, (stem, ending) = work / "earlier", os.path.splitext(name)
    folder.mkdir(parents=True, exist_ok=True)
    return next(path for n in range(1, 10**6) if not (path := folder / f"{stem}-{n}{ending}").exists())


def go_on(arguments):
    """The rest of the command, by the code that is here now."""
    sys.stdout.flush()
    return subprocess.call([sys.executable, str(ROOT / "run.py"), "update", "--carry-over", *arguments])


def git(*arguments):
    """What git prints, or None where it fails or is not installed."""
    try:
        done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    except OSError:
        return None
    return done.stdout if done.returncode == 0 else None
