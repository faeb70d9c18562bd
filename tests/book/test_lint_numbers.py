"""Numbers in prose: what is backed by a cell, what needs no backing, and what is found."""

import pytest

from book.chapters import lint_numbers
from book.setup.paths import ROOT
from tests.helpers.chapter import code, markdown, printed


def found(text, *cells):
    return [what.split(",")[0] for _, what in lint_numbers.problems([markdown(text), *cells])]


SHOWN = code("width_deg = 12.5\nassert gap < 0.06", outputs=[printed("tip at 204.765 mm, 38.6 % of 2_000\n")])


@pytest.mark.parametrize(
    "text",
    [
        "The tip is 204.765 mm up, or 204.8 mm, or 205 mm.",
        "It opens by 12.5°, the gap is below 0.06 mm, and 2000 samples were drawn.",
        "That is 0.205 m.",
        "As chapter 13 says, joints 2, 3 and 4 of the XM430-W350 are parallel; T is 4x4; exercise 5.17, 3-D, 1955.",
        "Four rows, 3 links, a quarter turn of 90°.",
        "The formula $q + 17.3$ and the call `f(17.3)` and [the page](17.ipynb).",
        "# 14 · Two drawings",
        "The maker says 380 mm.<!-- given: 380, the maker's manual -->",
    ],
)
def test_backed_or_free(text):
    assert found(text, SHOWN) == []


@pytest.mark.parametrize(
    ("text", "claim"),
    [
        ("It is 204.7 mm up.", "says 204.7mm"),
        ("Only 3 mm are missing.", "says 3mm"),
        ("In 40 % of the cases", "says 40%"),
        ("Turn by 45°.", "says 45°"),
        ("It takes 17 of them.", "says 17"),
        ("The tip is at (16, 4, 336).", "says 16"),
        ("That makes 18 751.77 of them.", "says 18 751.77"),
    ],
)
def test_found(text, claim):
    assert claim in found(text, code("x = 1"), SHOWN)


def test_a_number_given_in_one_cell_backs_no_other():
    cells = [markdown("380 mm <!-- given: 380, a manual -->"), markdown("It reaches 380 mm.")]
    assert [number for number, _ in lint_numbers.problems(cells)] == [2]


def test_names_of_symbols_and_colours_back_nothing():
    assert found("It is 30 % and 22 mm.", code("q30 = '#22aa00'")) == ["says 30%", "says 22mm"]


# ---- numbers in words --------------------------------------------------------------------------------------

CELLS = printed("cells: 2912 before, 1976 after; 268 deg/s, 60 planned; 12.5 deg; 67%\n")


@pytest.mark.parametrize(
    "text",
    [
        "A third of the cells are gone. <!-- so: 1 - 1976/2912 -->",
        "It was more than four times as fast, and *four times* as wide. <!-- so: 268/60, 3.9 --><!-- given: 3.9 -->",
        "Two thirds of it, and nearly seventy times as much.<!-- so: 67/100, 67 -->",
        "It is half a kilogram <!-- given: 0.5, the maker --> or ten to twelve degrees. <!-- so: 10, 12.5 -->",
        'Is it a quarter of the cells, or half of them? She says: "A quarter of the cells." Say it to a fifth.',
        "Half a turn, the third row, the upper half of it, told twice, three times from above, in doubles.",
        "That is 67 %.",
    ],
)
def test_words_that_are_backed_or_no_claim(text):
    assert found(text, code("x = 1", outputs=[CELLS])) == []


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("A quarter of the cells are gone. <!-- so: 1 - 1976/2912 -->", "'A quarter'"),
        ("Less than a third of the cells. <!-- so: 1976/2912 -->", "'Less than a third'"),
        ("It is six times as fast. <!-- so: 268/60 --><!-- given: 0.2 -->", "'six times'"),
        ("It nearly doubles.", "'nearly doubles'"),
        ("It takes five millimetres.", "'five millimetres'"),
        ("It is half a kilogram.", "'half a kilogram'"),
        ("It costs 5 degrees.", "5degrees"),
        ("Ten to thirty times better. <!-- so: 12/1.2 -->", "'Ten to thirty times'"),
        ("More than half of the error. <!-- so: 0.4 --><!-- given: 0.4 -->", "'More than half'"),
        ("It took 6e-13 mm.", "6e-13mm"),
    ],
)
def test_words_that_nothing_backs(text, says):
    assert f"says {says}" in found(text, code("x = [5, 0.5, 1e-12][:5]", outputs=[CELLS]))


def test_a_so_computes_from_what_the_chapter_prints():
    (what,) = found("A third of them. <!-- so: 653/1976 -->", code("x = 1", outputs=[CELLS]))
    assert "computes 653/1976" in what
    assert "and 653 no cell" in "".join(what for _, what in lint_numbers.problems([markdown("<!-- so: 653/1976 -->")]))


# ---- pages -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("page", lint_numbers.PAGES)
def test_each_number_of_a_page_stands_in_a_file_that_it_names(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    assert list(lint_numbers.page_problems(text)) == []
    for planted in ("It hangs by 23.71 mm.", "A ninth... no, two fifths of it.", "It is 41.3 % of all."):
        assert list(lint_numbers.page_problems(f"{text}\n{planted}\n")), planted


def test_a_section_of_a_page_is_backed_by_its_own_files(tmp_path):
    (tmp_path / "facts.py").write_text("assert reach_mm == 380\n")
    page = "# Page\n\n380 mm\n\n## A\n\n<!-- backed by: facts.py -->\n380 mm, 381 mm\n\n## B\n\n380 mm\n"
    assert [line for line, _ in lint_numbers.page_problems(page, tmp_path)] == [3, 8, 12]
