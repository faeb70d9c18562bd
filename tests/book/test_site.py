"""The site: what is built is complete, its kinematics are Python's, and one edit changes every product."""

import copy
import html
import json
import math
import re
from html.parser import HTMLParser
from urllib.parse import unquote, urldefrag

import pytest

import omx
from book.chapters import student
from book.chapters.cells import text_of
from book.chapters.normalise import normalise, read
from book.publish import deck, npm, pages, runs, site
from book.setup.paths import Stop
from omx.generated import fk, ik
from tests.helpers.chapter import chapter, code, markdown, printed
from tests.helpers.javascript import flat, in_node

Q = [(0.0, 0.0, 0.0, 0.0), omx.HOME, (0.3, 1.2, -0.9, 1.8), (3.1, -1.5, 1.4, -1.7), (-2.0, 0.1, 0.1, 3.3)]
POSES = [(274.0, 0.0, 204.8, 0.0), (0.0, 0.0, 300.0, 0.5), (16.0, 4.0, 336.0, 0.26), (600.0, 0.0, 204.0, 0.0)]


class Links(HTMLParser):
    """The targets and the anchors of a page."""

    def __init__(self, text):
        super().__init__()
        self.targets, self.anchors = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if (tag, name) in (("a", "href"), ("img", "src"), ("script", "src"), ("link", "href")) and value:
                self.targets.append(value)
            elif name in ("id", "name") and value:
                self.anchors.add(value)


@pytest.fixture(scope="module")
def links(built_site):
    """Each page of the site and its links."""
    found = sorted(path for path in built_site.rglob("*.html") if "_static" not in path.parts)
    return {path: Links(path.read_text(encoding="utf-8")) for path in found}


def test_every_link_inside_the_site_leads_somewhere(links):
    missing = []
    for page, found in links.items():
        for link in found.targets:
            target, anchor = urldefrag(link)
            if re.match(r"[a-z]+:", link):
                continue
            file = (page.parent / unquote(target.split("?")[0])).resolve() if target else page
            if not file.is_file() or (anchor and file in links and unquote(anchor) not in links[file].anchors):
                missing.append((page.name, link))
    assert missing == []


def test_nothing_on_the_site_is_loaded_from_elsewhere(links):
    for page in links:
        text = re.sub(r"<a\b[^>]*>", "", page.read_text(encoding="utf-8"))
        assert not re.search(r"(?:src|href)=[\"'](?:https?:)?//", text), page


def test_every_chapter_has_a_page_a_deck_and_a_download(built_site):
    for path in site.ROOT.glob("notebooks/*.ipynb"):
        assert (built_site / "notebooks" / f"{path.stem}.html").exists()
        assert (built_site / "slides" / f"{path.stem}.html").exists()
        assert (built_site / "_sources" / "notebooks" / path.name).read_bytes() == path.read_bytes()


def words(text):
    return html.unescape(re.sub(r"<[^>]+>", "", text)).strip()


def test_a_page_prints_what_the_cells_printed(built_site):
    """Line for line, also where a kernel said it in several pieces."""
    for path in runs.chapters():
        page = (built_site / "notebooks" / f"{path.stem}.html").read_text(encoding="utf-8")
        shown = [words(block) for block in re.findall(r"<pre>(.*?)</pre>", page, re.DOTALL)]
        for cell in runs.merged(path)["cells"]:
            for output in cell.get("outputs", ()):
                if output["output_type"] == "stream":
                    assert text_of(output["text"]).strip() in shown, (path.name, cell["id"])


def test_every_page_names_the_licence_of_its_text(links):
    for page in links:
        if page.parent.name in ("book", "notebooks", "teach", "api"):
            assert "Text: CC BY 4.0. Code: BSD 3-Clause" in page.read_text(encoding="utf-8"), page


def test_the_api_shows_no_value_that_nobody_reads(built_site):
    for page in (built_site / "book" / "api").glob("*.html"):
        heads = re.findall(r'<dt class="sig.*?</dt>', page.read_text(encoding="utf-8"), re.DOTALL)
        assert max(map(len, map(words, heads)), default=0) < 400, page
        assert "Alias for field number" not in page.read_text(encoding="utf-8")


def test_the_search_knows_each_exercise_by_its_number(built_site):
    text = (built_site / "searchindex.js").read_text(encoding="utf-8")
    entries = json.loads(text.removeprefix("Search.setIndex(").removesuffix(")"))["indexentries"]
    cells = [cell for path in runs.chapters() for cell in read(path)["cells"]]
    exercises = [m[0].lower() for c in cells if (m := site.EXERCISE.search("".join(c["source"]).split("\n")[0]))]
    assert len(exercises) > 100
    assert set(exercises) <= set(entries)


VARYING = """import sys, time, os
for piece in ("torn ", "in ", "pieces\\n"):
    sys.stdout.write(piece)
    sys.stdout.flush()
    time.sleep(0.05)
print(time.perf_counter_ns(), os.getpid())
print(list({"some", "words", "in", "the", "order", "of", "hashes"}))"""
SHOWN = """from omx import View, plots
view = View()
view.trail()
view.frames(0, 4)
plots.curves([0, 1], {"a": [0, 1]}, x="x (mm)", y="y (mm)", alt="A line from corner to corner.")
view"""


def test_two_builds_from_one_commit_are_the_same_bytes(tmp_path, monkeypatch):
    """Page, deck and sheet of a chapter run twice, with a cell that prints a clock, and one with a scene."""
    notebook = read(runs.chapters()[0])
    stored = printed("torn in pieces\n123 456\nwords\n")
    notebook["cells"][3:] = [*notebook["cells"][3:8], code(VARYING, tags=[runs.VARIES], outputs=[stored]), code(SHOWN)]
    path = tmp_path / runs.chapters()[0].name
    path.write_text(json.dumps(normalise(notebook)))
    monkeypatch.setattr(runs, "chapters", lambda: [path])
    made = []
    for folder in (tmp_path / "one", tmp_path / "two"):
        folder.mkdir()
        runs.run_all(folder=folder)
        whole = runs.merged(path, folder)
        made.append([pages.page(whole, path.stem), deck.sections(whole), student.student_copy(whole)])
    assert "data-poster" in json.dumps(made[0])
    assert "123 456" in json.dumps(made[0])
    assert json.dumps(made[0]) == json.dumps(made[1])


def test_nothing_on_the_site_knows_the_folder_of_its_build(built_site):
    whole = [path for path in built_site.rglob("*") if path.is_file() and path.suffix != ".printed"]
    assert [path.name for path in whole if str(site.ROOT).encode() in path.read_bytes()] == []
    assert not (built_site / ".buildinfo").exists()


def test_icons_in_use_are_kept_and_the_rest_is_gone(built_site):
    script = built_site / "_static" / "scripts" / "fontawesome.js"
    assert script.stat().st_size < 200_000
    text = script.read_text(encoding="utf-8")
    assert "magnifying-glass" in text
    assert "user-astronaut" not in text


# ---- kinematics in JavaScript -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "python", "arguments"),
    [
        ("fk.pose(...a)", fk.pose, Q),
        ("fk.frames(...a)", fk.frames, Q),
        ("fk.transform(...a)", fk.transform, Q),
        ("ik.branches(...a)", ik.branches, POSES),
        ("ik.missing(...a)", ik.missing, POSES),
    ],
)
@pytest.mark.parametrize("geometry", [omx.COURSE, omx.MAKER], ids=["course", "maker"])
def test_javascript_gives_the_numbers_of_python(expression, python, arguments, geometry):
    given = [[*a, *geometry.values] for a in arguments]
    for ours, theirs in zip(in_node(expression, given), given, strict=True):
        assert flat(ours) == pytest.approx(flat(python(*theirs)), rel=1e-12, abs=1e-11)


def test_javascript_carries_the_parameters():
    (parameters,) = in_node("fk.PARAMETERS", [0])
    assert parameters == pytest.approx(fk.PARAMETERS)
    assert list(parameters) == list(fk.PARAMETERS)
    assert parameters["delta"] == pytest.approx(math.asin(24 / 130))


# ---- one notebook, four products ------------------------------------------------------------------------------


def small():
    return normalise({"cells": [*chapter(), markdown("Say it slowly.", "notes")], "nbformat": 4})


def products(notebook):
    """Page, deck and sheet of a notebook, as texts."""
    made = (pages.page(notebook, "07-lines"), deck.sections(notebook), student.student_copy(notebook))
    return [json.dumps(product) for product in made]


def test_one_edit_changes_page_slide_and_sheet_together():
    edited = small()
    cell = next(cell for cell in edited["cells"] if "## Length" in "".join(cell["source"]))
    cell["source"] = ["## Length of a line\n"]
    for before, after in zip(products(small()), products(edited), strict=True):
        assert "Length of a line" not in before
        assert "Length of a line" in after


def test_prose_may_change_after_the_run_and_code_may_not(tmp_path):
    path, kept = tmp_path / "07-lines.ipynb", tmp_path / "kept"
    kept.mkdir()
    (kept / path.name).write_text(json.dumps(small()))
    edited = small()
    edited["cells"][0]["source"] = ["# Crooked lines"]
    path.write_text(json.dumps(edited))
    assert runs.merged(path, kept)["cells"][0]["source"] == ["# Crooked lines"]
    edited["cells"].append(normalise({"cells": [code("1 + 1")], "nbformat": 4})["cells"][0])
    path.write_text(json.dumps(edited))
    with pytest.raises(Stop, match=r"07-lines.ipynb was changed while the book was built"):
        runs.merged(path, kept)


def test_notes_are_for_the_speaker_only():
    page, slides, _ = products(small())
    assert "Say it slowly" not in page
    assert re.search(r'<div class=\\"note\\"[^>]*><p>Say it slowly', slides)


def test_a_page_folds_solutions_and_checks_and_leaves_the_notebook_alone():
    notebook = small()
    before = copy.deepcopy(notebook)
    page = pages.page(notebook, "07-lines")
    assert notebook == before
    folded = {tag for cell in page["cells"] for tag in cell["metadata"].get("tags", [])}
    assert {"hide-cell", "hide-input"} <= folded


def test_a_picture_brings_its_alt_text():
    picture = {
        "output_type": "display_data",
        "data": {"image/png": "x"},
        "metadata": {"image/png": {"alt": "A line.", "width": 9}},
    }
    cell = code("draw()", outputs=[picture])
    assert pages.prepared(cell)["metadata"]["mystnb"]["image"] == {"alt": "A line.", "width": "9px"}


@pytest.mark.parametrize(
    ("source", "outside"), [("**Predict.** How far?", ""), ("### Far\n\n**Predict.** How far?", "### Far")]
)
def test_a_question_to_predict_stands_in_a_box_whether_it_has_a_heading_or_not(source, outside):
    cell = {"cell_type": "markdown", "id": "a", "metadata": {"tags": ["predict"]}, "source": source}
    before, _, box = pages.prepared(cell)["source"].partition("::::::{div} omx-predict")
    assert before.strip() == outside
    assert box.strip() == "**Predict.** How far?\n::::::"


def test_no_line_of_a_page_begins_with_the_full_stop_after_a_formula():
    formula = '<span class="math notranslate nohighlight">\\(q_1\\)</span>'
    page = f"<p>{formula}, then {formula} (or {formula}).</p>"
    joined = site.INLINE.sub(r'<span class="omx-one">\1\2</span>', page)
    assert joined.count("omx-one") == 2
    assert f'<span class="omx-one">{formula},</span>' in joined
    assert f'<span class="omx-one">{formula}).</span>' in joined
    assert site.INLINE.sub("", joined) == joined, "the next build leaves it as it is"


def test_without_npm_one_sentence_says_what_to_do(monkeypatch, tmp_path):
    monkeypatch.setattr(npm.shutil, "which", lambda name: None)
    with pytest.raises(Stop, match=r"npm is not on this machine.*install Node\.js"):
        npm.modules(into=tmp_path / "npm")


def test_the_lock_file_names_no_host():
    text = (site.ROOT / "book" / "package-lock.json").read_text(encoding="utf-8")
    assert "http" not in text
    packages = json.loads(text)["packages"]
    assert all(about["integrity"].startswith("sha512-") for name, about in packages.items() if name)
