"""Decks: what is for the screen stands there, the rest is said; solutions never show."""

import ast
import html
import json
import re

import pytest

from book.publish import deck, handout, markup, slide_code, slide_content
from tests.helpers.chapter import SOLUTION, chapter, code, markdown, printed

SCENE = {
    "output_type": "display_data",
    "metadata": {},
    "data": {"text/html": '<div class="omx-scene" data-scene="x"></div>'},
}


def sections(*cells):
    return deck.sections({"cells": list(cells)})


def shown(text, tags=(), kind="-"):
    """The words of a cell on the screen, and those that are only said."""
    unit = deck.slide([markdown(text, kind, tags), code("run()")]).units[0]
    parts = "".join(unit.pieces[:1]), "".join(unit.notes)
    return (" ".join(html.unescape(re.sub(r"<[^>]*>", "", part)).split()) for part in parts)


def test_h2_goes_right_h3_goes_down():
    stacks = deck.stacks({"cells": cells_of("# A\n\na", "## B\n\nb", "### C\n\nc")})
    assert [len(stack) for stack in stacks] == [1, 2]


def cells_of(*texts):
    return [{"cell_type": "markdown", "metadata": {}, "source": text} for text in texts]


def test_no_slide_has_a_heading_only():
    first, second = deck.stacks(
        {"cells": cells_of("## Limits", "### Upper\n\nJoint 3 stops.", "Above a heading.\n\n### Lower\n\nIt stops.")}
    )[0]
    assert "Limits" in first.units[0].pieces[0]
    assert "Upper" in "".join(first.units[0].pieces)
    assert "Above a heading" in "".join(piece for unit in first.units for piece in unit.pieces)
    assert "Lower" in second.units[0].pieces[0]


@pytest.mark.parametrize(
    ("text", "on_screen"),
    [
        ("A rod turns about a hinge. It is long. Its end moves.", "A rod turns about a hinge."),
        (
            "A rod turns about a hinge. Call its length the **lever**.",
            "A rod turns about a hinge. Call its length the lever.",
        ),
        (
            "Rods are stiff things here. They turn. Twice it fails: at 0.5 mm and, e.g., at $a.B$.",
            "Rods are stiff things here.",
        ),
        ("No. The base faces away from it. More words.", "No. The base faces away from it."),
        (
            "The arm has four ways to go. Here the wrist is behind. So the **left** is below.",
            "The arm has four ways to go. Here the wrist is behind. So the left is below.",
        ),
        (
            "Why not ask a solver for it? Because it does not come back. We waited.",
            "Why not ask a solver for it? Because it does not come back.",
        ),
        (
            "The angle comes from two numbers. Both have a sign:\n\n$$x$$",
            "The angle comes from two numbers. Both have a sign: \\[x\\]",
        ),
        ("(A plane arm will do.) The arm moves in a plane. More.", "The arm moves in a plane."),
        ("(Three folded cells follow. Go on.)\n\nThe rest is plain to see.", "The rest is plain to see."),
        ("**Row 1: up.** Joint 1 turns the arm. The shoulder is high.", "Row 1: up. Joint 1 turns the arm."),
    ],
)
def test_what_of_a_paragraph_is_for_the_screen(text, on_screen):
    seen, said = shown(text)
    assert seen == on_screen
    if "$$" not in text:
        for sentence in slide_content.sentences(text.split("\n\n")[0]):
            words = re.sub(r"[*$]", "", sentence)
            assert words.split()[0] in seen + said


def test_a_question_stays_whole_and_its_answer_is_said():
    asked = "**Predict.** The arm is straight. Its elbow bends. Which way does the tip go?"
    seen, said = shown(asked, ["predict"])
    assert seen == asked.replace("*", "")
    assert "wait for hands" in said
    recall = "**1.** It turns. How far?\n\n<details><summary>Answer</summary>\n\nBy a tick.\n\n</details>"
    seen, said = shown(f"## Before\n\nThree questions from before.\n\n{recall}", ["recall"])
    assert "It turns. How far?" in seen
    assert "tick" not in seen
    assert "1. By a tick." in said


def test_every_word_is_on_the_screen_or_said():
    source = "## A\n\nOne two. Three four. Five **six**.\n\n- Seven eight. Nine.\n\n> Ten. Eleven.\n\n| a |\n|-|\n| b |"
    seen, said = shown(source)
    assert set(re.findall(r"\w+", source)) <= set(re.findall(r"\w+", seen + " " + said))


def test_fragments_and_notes():
    text = sections(
        markdown("## A", "slide"), markdown("the answer", "fragment"), markdown("*For the speaker.* Wait.", "notes")
    )
    assert '<div class="piece fragment"><p>the answer</p>' in text
    assert '<div class="note" data-seconds="1"><p>Wait.</p>' in text
    assert "For the speaker" not in text


def test_exercises_are_one_table_with_difficulty_and_minutes():
    text = sections(
        *cells_of("## Exercises"),
        markdown(
            "### Exercise 7.1 · Its name\n\n*Difficulty 2 of 5, about 10 minutes.*\n\nThe task.", tags=["exercise"]
        ),
        code("mine = 3"),
    )
    assert all(word in text for word in ("7.1", "Its name", "●●○○○", "10 min"))
    assert "The task" not in text
    assert "mine" not in text


def test_a_deck_takes_the_longer_the_more_there_is_to_do():
    talk = cells_of("## A\n\n" + "word " * 130)
    asked = [*talk, markdown("**Predict.** What?", tags=["predict"])]
    assert 0.9 < deck.minutes({"cells": talk}) < 1.1
    assert deck.minutes({"cells": asked}) > deck.minutes({"cells": talk}) + 1


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


LONG = """poses = [omx.pose(q) for q in grid if omx.is_legal(q) and omx.clearance(q) > 5.0]  # what is worth a line here
if poses:
    # the first that is found
    print(poses[0])
else:
    print("none")"""


def test_code_on_a_slide_has_lines_that_fit_and_says_the_same():
    notebook = {"cells": [code(LONG), markdown("# A")]}
    cell, same = slide_code.narrowed(notebook)["cells"]
    assert max(map(len, cell["source"].splitlines())) <= slide_code.COLUMNS
    assert ast.dump(ast.parse(cell["source"])) == ast.dump(ast.parse(LONG))
    assert cell["source"].splitlines()[0] == "# what is worth a line here"
    assert cell["metadata"]["lines"] == 5
    assert same == notebook["cells"][1]
    assert notebook["cells"][0]["source"] == LONG


def test_code_may_be_cut_where_a_statement_begins():
    assert slide_code.beginnings(LONG) == {1}
    assert slide_code.beginnings("half of (") == set()
    loop = "total = 0\nfor i in range(3):\n" + "    total += i\n" * 11
    assert slide_code.beginnings(loop) == {1}  # short enough to stay whole
    assert slide_code.beginnings(loop + "    total += i\n" * 2) == {1, *range(3, 15)}
    text = sections(markdown("## A"), code(LONG))
    assert text.count('class="line begins"') == 1
    assert text.count('class="line') == 6


def test_long_listings_are_cut_into_even_blocks_that_fit():
    lines = "\n".join(f"line {i}" for i in range(45))
    text = sections(markdown("## A", "slide"), code("run()", outputs=[printed(lines)]))
    sizes = [block.count("line") for block in text.split('<pre class="output">')[1:]]
    assert sizes == [15, 15, 15]
    assert all(f"line {i}" in text for i in range(45))


def test_no_tuple_is_cut_in_two():
    lines = [*(f"x{i} = {i}" for i in range(8)), "return (", *("    [1, 2]," for _ in range(14)), ")"]
    first, second = markup.blocks(lines)
    assert first == lines[:8]
    assert second == lines[8:]


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


def test_a_handout_has_the_same_bytes_from_any_folder_and_moment():
    pattern = (
        b"/CreationDate (D:2026010203040%d+00'00') /Creator (Mozilla/5.0 HeadlessChrome/9) "
        b"/ID (node00000%d) [(node00000%d)] /URI (beside:01.html) /URI (https://a.b/c)"
    )
    made = [pattern % (n % 7, n + 1, n) for n in (241, 777)]
    first, second = map(handout.unstamped, made)
    assert first == second
    assert len(first) == len(made[0]), "the places of what follows stand in the file"
    assert b"/ID (node00000001) [(node00000000)] /URI (01.html)       " in first
    assert b"/URI (https://a.b/c)" in first
