"""Numbers in prose: what is backed by a cell, what needs no backing, and what is found."""

import pytest

from book.chapters import lint_numbers
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
