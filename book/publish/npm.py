"""The browser's libraries, fetched once into build/npm by npm and the lock file; nothing of them is in the repository.

    python -m book.publish.npm                    # fetch them now

Later builds need no network: the folder is used as long as the lock file is the one it was made from.
"""

import hashlib
import os
import shutil
import subprocess
import sys

from book.setup.file_lock import one_at_a_time
from book.setup.paths import BUILD, ROOT, Stop

FLAGS = ("--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error")


def modules(folder=ROOT / "book", into=BUILD / "npm"):
    """The path of node_modules for the package.json and lock in `folder`; fetches them if need be. Raises `Stop`."""
    lock = folder / "package-lock.json"
    stamp, wanted = into / "complete", hashlib.sha256(lock.read_bytes()).hexdigest()
    with one_at_a_time(lock):
        if not (stamp.exists() and stamp.read_text() == wanted):
            fetch(folder, into)
            stamp.write_text(wanted)
    return into / "node_modules"


def fetch(folder, into):
    """Run `npm ci` in `into` with the files of `folder`."""
    npm = shutil.which("npm")
    if npm is None:
        raise Stop(
            "npm is not on this machine; the site and the slides take MathJax and reveal.js from it, once: install "
            "Node.js (version 18 or newer; it brings npm) and run the same command again. The notebooks need neither."
        )
    into.mkdir(parents=True, exist_ok=True)
    (into / "complete").unlink(missing_ok=True)
    for name in ("package.json", "package-lock.json"):
        shutil.copyfile(folder / name, into / name)
    done = subprocess.run([npm, "ci", *FLAGS], cwd=into, env=environment(), capture_output=True, text=True, check=False)
    if done.returncode:
        said = (done.stderr or done.stdout).strip().splitlines()
        raise Stop(
            f"npm could not fetch the browser's libraries ({said[0][:160] if said else 'it said nothing'}): check the "
            "network connection and run the same command again; this is needed only once."
        )


def environment():
    """The variables for npm and node, without its update notice."""
    return {**os.environ, "NO_UPDATE_NOTIFIER": "1", "NPM_CONFIG_UPDATE_NOTIFIER": "false"}


def main():
    try:
        print(modules())
    except Stop as stop:
        print(f"npm: {stop}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
