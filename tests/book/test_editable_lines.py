"""What a page takes of a chapter to derive again: it writes the same bytes, and shows nothing on the way."""

import copy
import inspect

import pytest

import omx
from book.chapters import cells, normalise
from book.publish import derive_again, pages, runs
from book.publish.editable_lines import recipe
from omx.derive import write_chain
from omx.derive.store import GENERATED


def chapter(name):
    return next(path for path in runs.chapters() if path.stem.endswith(name))


def changed(chapters, *edits):
    """The chapters with each first text replaced by the second, in the lines that a reader may change."""
    chapters = copy.deepcopy(chapters)
    for old, new in edits:
        (piece,) = [p for c in chapters for p in c["pieces"] if "edit" in p and old in p["code"]]
        piece["code"] = piece["code"].replace(old, new)
    return chapters


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """What is written here stays out of the package, and of the repository."""
    monkeypatch.setenv("OMX_GENERATED", str(tmp_path))
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path


def texts(found):
    return {file["name"]: file["text"] for file in found["files"]}


@pytest.mark.parametrize("name", ["forward-kinematics", "inverse-kinematics"])
def test_it_writes_what_the_chapter_writes(name):
    for file, text in texts(derive_again.again(recipe(chapter(name)))).items():
        assert text == (GENERATED / file).read_text(encoding="utf-8")


def test_another_length_is_one_line_and_another_row_another_formula():
    book = recipe(chapter("forward-kinematics"))
    before = (GENERATED / "fk.py").read_text(encoding="utf-8")
    longer = texts(derive_again.again(changed(book, ("L4: 126", "L4: 150"))))["fk.py"]
    assert longer == before.replace('"L4": 126.0', '"L4": 150.0')
    signs = [sign for sign, _ in derive_again.difference(before, longer)]
    assert (signs.count("-"), signs.count("+")) == (1, 1)
    tilted = texts(derive_again.again(changed(book, ("a=L4, alpha=0", "a=L4 + 20, alpha=0.5"))))["fk.py"]
    module = {}
    exec(tilted, module)
    rows = module["dh_rows"](*module["PARAMETERS"].values())
    q = [0.3, -0.4, 0.5, -0.6]
    assert module["transform"](*q, *module["PARAMETERS"].values()) == pytest.approx(omx.Chain(rows).fk(q), abs=1e-9)
    assert rows[3].a == 146


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("L4: 126", "L4: 0", "L4 = 0 mm makes no arm: every length must be more than 0. Nothing was written."),
        ("L4: 126", "L4: oo", "NameError: name 'oo' is not defined"),
        ("L4: 126,", "L4: 126 +,", "Line 5 of lengths cannot be read: invalid syntax."),
        ("alpha=-sp.pi / 2", "alpha='down'", "an expression or a number is wanted; got 'down'."),
        ("a=L3, alpha=0", "a=L3, alpha=0.3", "sin(pitch) - the vertical part of the hand's direction is not 0;"),
    ],
)
def test_what_makes_no_arm_is_refused_in_the_packages_words(old, new, said, elsewhere):
    found = derive_again.again(changed(recipe(chapter("forward-kinematics")), (old, new)))
    assert list(found) == ["refused"]
    assert found["refused"].startswith(said)
    assert not list(elsewhere.glob("*.py"))


def test_a_chain_of_any_chapter_is_written_by_its_table(elsewhere):
    (planar,) = recipe(chapter("planar-arms"))
    written = texts(derive_again.again(changed([planar], ("0, 100, 0", "0, 150, 0"))))["planar.py"]
    chain = omx.Chain([omx.DHRow(0, 0, a, 0) for a in (200, 200, 150)], name="three planar links")
    assert written == inspect.getsource(write_chain("planar", chain, folder=elsewhere / "by hand"))
    found = derive_again.again(changed(recipe(chapter("other-arms")), ("d6: 100", "d6: 150")))
    assert found["arm"]["about"]["rows"][5]["d"] == 150
    assert found["arm"]["about"]["names"][2] == "d3"


def test_pages_with_such_lines_hold_them_and_their_own_cells_stay_as_they_are():
    for path in runs.chapters():
        notebook = normalise.read(path)
        marked = any("your-arm" in cells.tags(cell) for cell in notebook["cells"])
        shown = [cell for cell in pages.page(notebook, path.stem)["cells"] if "omx-edit" in cells.source(cell)]
        assert len(shown) == marked
        for made in recipe(path) if marked else ():
            for piece in made["pieces"]:
                assert "edit" not in piece or any(piece["code"] in cells.source(cell) for cell in runs_of(made["name"]))
                assert "show(" not in piece["code"]


def runs_of(name):
    return normalise.read(normalise.NOTEBOOKS / f"{name}.ipynb")["cells"]
