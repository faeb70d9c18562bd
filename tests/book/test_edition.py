"""The student's edition: nothing of a teacher's in it, and it works where it is unpacked, with an empty home."""

import os
import re
import subprocess
import sys
import zipfile

import pytest

from book.chapters import edition, generate, normalise
from book.chapters.cells import source, tags
from book.setup.paths import ENVIRONMENT, package_of

SHEETS = sorted(path.name for path in normalise.NOTEBOOKS.glob("*.ipynb"))
KEPT = ("tests/", "book/teach", "publish/site", "publish/slides", "deck", "book/hub", ".git", ".ci", "CHANGELOG",
        "CONTRIBUTING", "edition.py", "grading", "grader", "hidden", "__pycache__", ".progress.json")  # fmt: skip


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    """The book's folder as a student unpacks it."""
    folder = tmp_path_factory.mktemp("stick")
    assert edition.main(["--edition", str(folder / "stick.zip")]) == 0
    with zipfile.ZipFile(folder / "stick.zip") as archive:
        archive.extractall(folder)
    return folder / "omx-book"


def test_nothing_that_a_teacher_keeps_is_in_it(unpacked):
    names = [path.relative_to(unpacked).as_posix() for path in unpacked.rglob("*") if path.is_file()]
    assert not [name for name in names if any(part in name for part in KEPT)]
    assert sorted(path.name for path in (unpacked / "notebooks").iterdir()) == SHEETS
    for path in (unpacked / "notebooks").iterdir():
        cells = normalise.read(path)["cells"]
        assert all("TODO" in source(c) for c in cells if "solution" in tags(c) and c["cell_type"] == "code")
        assert not any(cell.get("outputs") for cell in cells)


def test_the_pages_that_chapters_name_go_along(unpacked):
    for path in (unpacked / "notebooks").iterdir():
        for page in re.findall(r"\]\(\.\./([\w/.-]+)", path.read_text(encoding="utf-8")):
            assert (unpacked / page).is_file(), f"{path.name} links to {page}"


def test_a_solution_or_a_note_anywhere_in_it_is_found():
    files = edition.contents()
    assert edition.leaks(files) == []
    path = next(p for p in generate.NOTEBOOKS.glob("03-*.ipynb"))
    solution = next(source(cell) for cell in normalise.read(path)["cells"] if "solution" in tags(cell))
    files["book/notation.md"] += solution.encode()
    assert edition.leaks(files)[0].startswith("book/notation.md: ")


def test_checks_of_graded_chapters_stay_with_the_grader():
    files = edition.contents(graded=("03",))
    for name, content in files.items():
        if name.startswith("notebooks/"):
            assert (b"check.handed_in(" in content) == name.startswith("notebooks/03")


def test_two_builds_have_the_same_bytes(unpacked, tmp_path):
    edition.write(tmp_path / "again.zip")
    assert (tmp_path / "again.zip").read_bytes() == (unpacked.parent / "stick.zip").read_bytes()


def test_packages_beside_it_fit_every_python_of_their_minor_version():
    """A pin that hangs on the last number of the Python goes along in each version that may be asked for."""
    lines = [
        *("# by hand", "numpy==2.4.6  # a reason", "colorama==0.4.6 ; sys_platform == 'nowhere'"),
        *("soupsieve==2.10 ; python_full_version < '3.11.5'", "soupsieve==4.1.2 ; python_full_version >= '3.11.5'"),
        *("contourpy==1.3.3 ; python_full_version < '3.12'", "contourpy==1.4.0 ; python_full_version >= '3.12'"),
    ]
    first = ["numpy==2.4.6", "soupsieve==2.10", "contourpy==1.3.3"]
    assert edition.alternatives(lines, (3, 11)) == [first, ["soupsieve==4.1.2"]]
    assert edition.alternatives(lines, (3, 12)) == [["numpy==2.4.6", "soupsieve==4.1.2", "contourpy==1.4.0"]]
    pinned = ENVIRONMENT.read_text(encoding="utf-8").splitlines()
    for pins in edition.alternatives(pinned, sys.version_info[:2]):
        assert len({package_of(pin) for pin in pins}) == len(pins), "no installer takes a package twice"


def test_it_runs_where_it_is_unpacked(unpacked, tmp_path):
    home = tmp_path / "home"
    home.mkdir()
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("HOME", "PYTHON", "JUPYTER"))}
    variables = {**kept, "HOME": str(home), "PYTHONPATH": str(unpacked)}

    def said(*arguments):
        done = subprocess.run([sys.executable, *arguments], cwd=unpacked, env=variables, capture_output=True, text=True,
                              timeout=120, check=False)  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done.stdout

    commands = said("run.py")
    assert "lab " in commands
    assert "generate " in commands
    assert "student" not in commands
    assert "check " not in commands
    assert said("-c", "import omx; print(omx.__file__)").strip() == str(unpacked / "omx" / "__init__.py")
    code = ("from book.chapters import execute, normalise; p = normalise.NOTEBOOKS / '00-start-here.ipynb'; "
            "print([o.text for c in execute.run(p).cells for o in c.get('outputs', []) if 'text' in o])")  # fmt: skip
    assert "ok  kinematics" in said("-c", code)


ALL = """import importlib, pathlib
for path in sorted(pathlib.Path("book").rglob("*.py")):
    name = ".".join(path.with_suffix("").parts)
    if not name.endswith("__init__"):
        importlib.import_module(name)
print("all", "there")
"""


def test_every_module_in_it_finds_what_it_imports(unpacked):
    done = subprocess.run([sys.executable, "-c", ALL], cwd=unpacked, capture_output=True, text=True, check=False,
                          env={**os.environ, "PYTHONPATH": str(unpacked)})  # fmt: skip
    assert done.stdout == "all there\n", done.stderr


def test_readers_commands_work_in_it(unpacked, tmp_path):
    """The folder of copies, a chapter given back, the file to hand in: without tests, tools, or the network."""
    variables = {**os.environ, "PYTHONPATH": str(unpacked), "HOME": str(tmp_path)}
    for command in (["folder", "update"], ["folder", "reset", "00"], ["handin", "00"]):
        done = subprocess.run([sys.executable, "-m", f"book.reader.{command[0]}", *command[1:]], cwd=unpacked,
                              env=variables, capture_output=True, text=True, check=False)  # fmt: skip
        assert done.returncode == 0, done.stderr
    assert len(list((unpacked / "work").glob("*.ipynb"))) == len(SHEETS) + 1
    (page,) = (unpacked / "work").rglob("*.html")
    assert "exercises pass their checks" in page.read_text(encoding="utf-8")


def test_a_sheet_generates_the_modules_as_its_chapter_does(unpacked, tmp_path, monkeypatch):
    monkeypatch.setattr(generate, "NOTEBOOKS", unpacked / "notebooks")
    generate.run_notebook("03-forward-kinematics", tmp_path)
    for name in ("fk.py", "fk.js"):
        assert (tmp_path / name).read_bytes() == (generate.GENERATED / name).read_bytes()
