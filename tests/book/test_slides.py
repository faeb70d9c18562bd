"""Decks: cells become slides by their slide type, with notes, fragments and alt texts; solutions never show."""

import json

from book.publish import deck
from tests.helpers.chapter import SOLUTION, chapter, code, markdown, printed

SCENE = {
    "output_type": "display_data",
    "metadata": {},
    "data": {"text/html": '<div class="omx-scene" data-scene="x"></div>'},
}


def sections(*cells):
    return deck.sections({"cells": list(cells)})


def test_h2_goes_right_h3_goes_down():
    stacks = deck.stacks(
        {"cells": [markdown("# A", "slide"), markdown("## B", "slide"), markdown("### C", "subslide")]}
    )
    assert [len(stack) for stack in stacks] == [1, 2]


def test_fragments_and_notes():
    text = sections(markdown("## A", "slide"), markdown("the answer", "fragment"), markdown("wait here", "notes"))
    assert '<div class="fragment"><p>the answer</p>' in text
    assert '<aside class="notes"><p>wait here</p>' in text


def test_what_is_skipped_or_a_solution_does_not_show():
    text = sections(*chapter())
    assert "import math" not in text
    assert SOLUTION.splitlines()[-1] not in text
    assert "Right." not in text
    assert "Another line" in text or "another line" in text


def test_a_scene_stands_without_its_code_and_a_number_with_it():
    text = sections(
        markdown("## A", "slide"), code("show(arm)", outputs=[SCENE]), code("print(5)", outputs=[printed("5\n")])
    )
    assert "omx-scene" in text
    assert "show" not in text
    assert "print" in text
    assert '<pre class="output">5</pre>' in text


def test_long_listings_are_cut_into_blocks_that_fit():
    lines = "\n".join(f"line {i}" for i in range(45))
    text = sections(markdown("## A", "slide"), code("run()", outputs=[printed(lines)]))
    assert text.count('<pre class="output">') == 3
    assert all(f"line {i}" in text for i in range(45))


def test_maths_is_left_for_mathjax_and_html_is_not():
    text = sections(
        markdown("## A\n\n$a < b$ and\n\n$$\nx_1 \\\\ y\n$$", "slide"), code("2 < 3", outputs=[printed("<b>")])
    )
    assert "\\(a &lt; b\\)" in text
    assert "\\[x_1 \\\\ y\\]" in text
    assert "&lt;b&gt;" in text


def test_sympy_results_are_displayed_formulas():
    out = {
        "output_type": "execute_result",
        "metadata": {},
        "execution_count": 1,
        "data": {"text/latex": "$\\displaystyle x^{2}$"},
    }
    assert "\\[x^{2}\\]" in sections(markdown("## A", "slide"), code("x**2", outputs=[out]))


def test_pictures_have_alt_texts():
    data = {"image/png": "iVBORw0KGgo=", "text/plain": "Figure: two links"}
    with_alt = {
        "output_type": "display_data",
        "data": data,
        "metadata": {"image/png": {"alt": 'a "bent" arm', "width": 400}},
    }
    without = {"output_type": "display_data", "data": data, "metadata": {}}
    text = sections(markdown("## A", "slide"), code("draw()", outputs=[with_alt, without]))
    assert 'alt="a &quot;bent&quot; arm" width="400"' in text
    assert 'alt="Figure: two links"' in text


def test_links_lead_to_decks_or_lose_their_target():
    text = sections(markdown("## A\n\n[four](04-inverse.ipynb#x), [errata](../book/errata.md), [self](#here)", "slide"))
    assert 'href="04-inverse.html"' in text
    assert "errata</p>" in text or ", errata," in text
    assert "errata.md" not in text
    assert 'href="#here"' in text


def test_a_deck_depends_on_nothing_but_its_notebook():
    cells = chapter()
    assert sections(*cells) == sections(*json.loads(json.dumps(cells)))
