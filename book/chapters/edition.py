"""The student's edition: everything that a student needs, in one ZIP file, and nothing that a teacher keeps.

    python run.py student --edition stick.zip [--graded 03,05] [--wheels]
    python run.py student [--to FOLDER] [03 ...]       only the sheets, into build/student

In it: the sheets in place of the chapters, `omx`, the launcher and what it needs, the pages that chapters link to.
Not in it: solutions, speaker's notes, tests, teaching pages, the grader, history. Fails closed, as the sheets do.
"""

import argparse
import ast
import re
import subprocess
import sys
import tempfile
import venv
import zipfile
from pathlib import Path

from packaging.markers import Marker

from book.chapters import normalise
from book.chapters.cells import slide_type, source, tags
from book.chapters.student import Refused, give_out, kept_lines, secret_lines, squeeze, student_copy
from book.setup.installers import MADE_FOR, this_system
from book.setup.paths import (
    BUILD,
    ENVIRONMENT,
    ROOT,
    WINDOWS,
    Stop,
    child_environment,
    in_a_sentence,
    package_of,
    whole,
)

STUDENT = BUILD / "student"

#: What goes along, by glob, with all modules that it imports, and what of that stays here.
ALONG = (
    "run.py", "environment.txt", "LICENSE", "omx/**/*", "book/__init__.py", "book/setup/**/*", "book/reader/**/*",
    "book/chapters/__init__.py", "book/chapters/generate.py", "book/chapters/execute.py", "book/publish/__init__.py",
    "book/publish/placeholders.js", "book/notation.md", "book/errata.md", "book/glossary.md", "book/bibliography.md",
    "book/files.md",
    "book/static/arm.png", "book/static/house.css", "book/templates/handin.html",
)  # fmt: skip
STAYS = re.compile(
    r"(^|/)(__pycache__|\.ipynb_checkpoints|\.DS_Store)(/|$)|^book/(setup/(lock|extra_envs)|chapters/edition)\.py$"
)
DATE = (2000, 1, 1, 0, 0, 0)  # the same bytes from the same book
README = """# Kinematics of the OpenMANIPULATOR-X

A book of Jupyter notebooks about the kinematics of a real four-joint arm, and the module `omx` that they write.

    python run.py lab       opens the book; the first time it sets itself up, in about a minute
    python run.py           lists all commands

You need Python 3.11 or newer (on Windows type `py run.py lab`, where there is no `python` type `python3`) and about
1.2 GB of disk. {network}

The chapters open as your own copies, in `work/`: write your answers where a cell says TODO, run the cell below it,
save, and hand in that notebook, or the one file that `python run.py handin 03` writes of it. No command overwrites
what you wrote. Code: BSD 3-Clause. Prose: CC BY 4.0. Both are in `LICENSE`.
"""
ONLINE = "Set-up needs the internet once, nothing else does."
OFFLINE = "The packages are in `wheels/`, made for {system}: there, set-up needs no internet."
PROJECT = """[build-system]
requires = ["setuptools"]
build-backend = "setuptools.build_meta"

[project]
name = "omx"
version = "0.1.0"
requires-python = ">=3.11"
dependencies = ["numpy"]

[tool.setuptools.packages.find]
include = ["omx*"]
"""


def write(target, wheels=False, root=ROOT, graded=()):
    """Write the edition; its path. Raises `Refused` or `Stop`, and then leaves no file."""
    target = Path(target).resolve()
    if target.is_dir() or not target.parent.is_dir():
        raise Stop(f"{target} cannot be written: name a file, in a folder that is there.")
    files = contents(root, graded)
    found = leaks(files, root)
    if found:
        raise Refused(f"a solution or note can still be read in the edition: {'; '.join(found[:3])}")
    with whole(target) as partial:
        pack(partial, files, wheels)
    return target


def pack(path, files, wheels):
    """Write the files, and the packages where they are wanted, into an archive."""
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        if wheels:
            download(Path(folder))
            files.pop("book/setup/hashes.txt", None)  # what was built here has other hashes
            files[MADE_FOR.relative_to(ROOT).as_posix()] = f"{this_system()}\n".encode()
        files["README.md"] = README.format(network=OFFLINE.format(system=this_system()) if wheels else ONLINE).encode()
        for name in sorted(files):
            add(archive, name, files[name])
        for wheel in sorted(Path(folder).iterdir()):
            add(archive, f"wheels/{wheel.name}", wheel.read_bytes(), zipfile.ZIP_STORED)


def contents(root=ROOT, graded=()):
    """{name in the edition: bytes}; the checks of `graded` chapters, such as "03", stay here."""
    names = {path.relative_to(root).as_posix() for glob in ALONG for path in root.glob(glob) if path.is_file()}
    names = with_imports({name for name in names if not STAYS.search(name)}, root)
    files = {name: (root / name).read_bytes() for name in names}
    for path in sorted((root / "notebooks").glob("*.ipynb")):
        files[f"notebooks/{path.name}"] = normalise.dumps(
            student_copy(normalise.read(path), path.name[:2] in graded)
        ).encode()
    return {**files, "pyproject.toml": PROJECT.encode()}


def with_imports(names, root):
    """The names, and those of all modules of `book` that they import, one after the other."""
    found, waiting = set(names), [name for name in names if name.startswith("book/") and name.endswith(".py")]
    while waiting:
        for node in ast.walk(ast.parse((root / waiting.pop()).read_text(encoding="utf-8"))):
            modules = [alias.name for alias in getattr(node, "names", ())] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.module:
                modules = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            new = {f"{module.replace('.', '/')}.py" for module in modules if module.startswith("book.")} - found
            new = {name for name in new if (root / name).is_file() and not STAYS.search(name)}
            found |= new
            waiting += new
    return found


def leaks(files, root=ROOT):
    """Where in the edition a line of a solution or note stands that no other cell of the chapters shows."""
    text = {name: squeeze(content.decode("utf-8", "replace")) for name, content in files.items()
            if name.endswith((".md", ".ipynb", ".py"))}  # fmt: skip
    cells = [cell for path in sorted((root / "notebooks").glob("*.ipynb")) for cell in normalise.read(path)["cells"]]
    hidden = [cell for cell in cells if "solution" in tags(cell) or slide_type(cell) == "notes"]
    shown = squeeze("\n".join(source(cell) for cell in cells if cell not in hidden))
    kept = squeeze("\n".join(line for c in hidden if c["cell_type"] == "code" for line in kept_lines(source(c))))
    lines = {line for cell in hidden for line in secret_lines(cell)}
    secrets = [line for line in lines if len(line) > 24 and line not in shown and line not in kept]
    return [f"{name}: {line}" for line in sorted(secrets) for name in sorted(text)
            if name.startswith(("notebooks/", "book/")) and line.replace('"', '\\"') in text[name]]  # fmt: skip


def add(archive, name, content, how=zipfile.ZIP_DEFLATED):
    about = zipfile.ZipInfo("omx-book/" + name, DATE)
    about.external_attr, about.compress_type = (0o755 if name == "run.py" else 0o644) << 16, how
    archive.writestr(about, content)


def download(folder):
    """Put the pinned packages for this system and every Python of this minor version into a folder. Raises `Stop`."""
    with tempfile.TemporaryDirectory() as place:
        venv.EnvBuilder(with_pip=True, symlinks=not WINDOWS).create(place)
        pip = [str(Path(place, "Scripts/python.exe" if WINDOWS else "bin/python")), "-m", "pip", "wheel", "--quiet"]
        options = ["--disable-pip-version-check", "--no-deps", "--ignore-requires-python", "--wheel-dir", str(folder)]
        for pins in alternatives(ENVIRONMENT.read_text(encoding="utf-8").splitlines(), sys.version_info[:2]):
            done = subprocess.run([*pip, *options, *pins], capture_output=True, text=True, check=False,
                                  env=child_environment())  # fmt: skip
            if done.returncode:
                last = (done.stderr or done.stdout).strip().splitlines() or ["it said nothing"]
                raise Stop(f"The packages could not be downloaded: {last[-1][:200]}")


def alternatives(lines, minor):
    """Lists of pins, no package twice in one, of all that some Python of this minor version, such as (3, 11), asks for.

    A marker may ask for the last number (`python_full_version < "3.11.5"`), and the class may have another.
    """
    needed = {}
    for line in lines:
        if package := package_of(line):
            pin, _, marker = line.partition("#")[0].partition(";")
            holds = Marker(marker.strip()).evaluate if marker else lambda _: True
            version = ".".join(map(str, minor))
            pythons = [{"python_version": version, "python_full_version": f"{version}.{last}"} for last in range(100)]
            if any(map(holds, pythons)):
                needed.setdefault(package, []).append(pin.strip())
    return [[pins[n] for pins in needed.values() if n < len(pins)] for n in range(max(map(len, needed.values())))]


# ---- the command `student` ----


@in_a_sentence
def main(argv=None):
    parser = argparse.ArgumentParser("python run.py student", description="The chapters as students get them.")
    parser.add_argument("notebooks", nargs="*", help="default: every chapter")
    parser.add_argument("--to", type=Path, default=STUDENT, metavar="FOLDER", help="default: build/student")
    parser.add_argument("--edition", type=Path, metavar="FILE.zip", help="all that a student needs, in one file")
    parser.add_argument("--graded", default="", metavar="03,05", help="chapters whose checks stay with the grader")
    parser.add_argument("--wheels", action="store_true", help="with the packages for this system, to install offline")
    options = parser.parse_args(argv)
    graded = tuple(options.graded.split(",")) if options.graded else ()
    if options.edition:
        print(write(options.edition, options.wheels, graded=graded))
        return 0
    options.to.mkdir(parents=True, exist_ok=True)
    paths = normalise.chapters(options.notebooks)
    return 1 if [path for path in paths if not wrote(path, options.to / path.name, graded)] else 0


def wrote(path, target, graded=()):
    """Write the sheet of one chapter and say so; False, with a sentence, if there is none now."""
    try:
        sheet, reason = student_copy(normalise.read(path), path.name[:2] in graded), ""
    except Refused as refused:
        sheet, reason = None, f"{path}: no copy made: {refused}"  # an older copy must not pass for this one
    if not give_out(target, sheet):
        reason = f"{target} was filled in or changed, so it stays; move it away to get a new one. {reason}".strip()
    print(reason or target, file=sys.stderr if reason else sys.stdout)
    return not reason


if __name__ == "__main__":
    sys.exit(main())
