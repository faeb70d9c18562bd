"""The stored form of a notebook: text stays, pictures and timings go, twice is once."""

import json

import nbformat
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from book.chapters import edition, execute, lint, lint_numbers, normalise
from book.reader import handin
from tests.helpers.chapter import chapter, code, markdown, printed

PNG = {
    "output_type": "display_data",
    "data": {"image/png": "iVBOR", "text/plain": "<Figure size 640x480>"},
    "metadata": {},
}
WIDGET = {
    "output_type": "display_data",
    "data": {"application/vnd.jupyter.widget-view+json": {"model_id": "3f"}, "text/plain": "IntSlider(value=0)"},
    "metadata": {},
}
SCENE = {"output_type": "display_data", "data": {"text/html": ["<div>\n", "<script>1</script></div>"]}, "metadata": {}}
LATEX = {
    "output_type": "execute_result",
    "execution_count": 57,
    "data": {"text/latex": "$\\displaystyle x^{2}$", "text/plain": "x**2"},
    "metadata": {"isolated": True},
}
TABLE = {"output_type": "display_data", "data": {"text/html": "<table></table>"}, "metadata": {}}


def normal(*cells, **top):
    return normalise.normalise({"cells": list(cells), "nbformat": 4, **top})


def outputs_of(*outputs):
    return normal(code("x", outputs=outputs))["cells"][0]["outputs"]


@pytest.mark.parametrize("picture", [PNG, WIDGET, SCENE], ids=["image", "widget", "scene"])
def test_pictures_go_and_with_them_the_count(picture):
    cell = normal(code("show()", outputs=[picture]))["cells"][0]
    assert cell["outputs"] == []
    assert cell["execution_count"] is None


def test_text_latex_and_tables_stay_with_the_count_of_their_place():
    cells = normal(code("a = 1"), markdown("b"), code("c", outputs=[printed("hi\n"), PNG, LATEX, TABLE]))["cells"]
    assert [cell.get("execution_count") for cell in cells] == [None, None, 2]
    text, latex, table = cells[2]["outputs"]
    assert text["text"] == ["hi\n"]
    assert latex["data"] == {"text/latex": ["$\\displaystyle x^{2}$"], "text/plain": ["x**2"]}
    assert latex["execution_count"] == 2
    assert latex["metadata"] == {}
    assert table["data"] == {"text/html": ["<table></table>"]}


def test_pieces_of_a_stream_are_joined_but_not_across_another():
    pieces = outputs_of(printed("a"), printed("b\nc"), LATEX, printed("d"))
    assert [piece.get("text") for piece in pieces] == [["ab\n", "c"], None, ["d"]]


def test_an_error_keeps_its_message_without_the_traceback():
    error = {"output_type": "error", "ename": "ValueError", "evalue": "no", "traceback": ["\x1b[31m/a/path", "line 3"]}
    assert outputs_of(error)[0]["traceback"] == ["ValueError: no"]


def test_metadata_of_editors_goes():
    cell = {**code("x"), "metadata": {"tags": ["play"], "execution": {"shell": 1}, "collapsed": True, "trusted": True}}
    top = {"widgets": {"state": {}}, "kernelspec": {"name": "other"}, "language_info": {"version": "3.99"}}
    notebook = normal(cell, metadata=top)
    assert notebook["cells"][0]["metadata"] == {"tags": ["play"]}
    assert notebook["metadata"] == {"kernelspec": normalise.KERNELSPEC, "language_info": normalise.LANGUAGE}


def test_ids_stay_and_missing_ones_are_filled():
    first = normal(code("a"), code("b"), code("a"))["cells"]
    assert len({cell["id"] for cell in first}) == 3
    first[1]["source"] = ["a typo mended"]
    again = normal(*first, code("new"))["cells"]
    assert [cell["id"] for cell in again[:3]] == [cell["id"] for cell in first]
    twin = normal(first[0], first[0])["cells"]
    assert twin[0]["id"] != twin[1]["id"]


def test_slide_types_that_a_heading_says_are_not_stored():
    heading = {**markdown("## Two"), "metadata": {"slideshow": {"slide_type": "slide"}}}
    plain = {**markdown("words"), "metadata": {"slideshow": {"slide_type": "-"}}}
    answer = {**markdown("so"), "metadata": {"slideshow": {"slide_type": "fragment"}}}
    kept = [cell["metadata"] for cell in normal(heading, plain, answer)["cells"]]
    assert kept == [{}, {}, {"slideshow": {"slide_type": "fragment"}}]


def test_other_formats_are_refused():
    with pytest.raises(ValueError, match="nbformat 4"):
        normalise.normalise({"nbformat": 3, "worksheets": []})


def test_the_stored_form_is_a_valid_notebook():
    nbformat.validate(normal(*chapter(), code("y", outputs=[LATEX, TABLE, printed("z")])))


CELLS = st.builds(
    lambda make, source, outputs: make(source) if make is markdown else make(source, outputs=outputs),
    st.sampled_from([markdown, code]),
    st.text("ab \n\r#é", max_size=12),
    st.lists(st.sampled_from([PNG, WIDGET, SCENE, LATEX, TABLE, printed("a"), printed("b\n")]), max_size=4),
)


@given(st.lists(CELLS, max_size=5))
@example([markdown("\r\r\na")])
@settings(deadline=None)
def test_twice_is_once_also_through_nbformat(cells):
    once = normalise.dumps(normal(*cells))
    assert normalise.dumps(normalise.normalise(json.loads(once))) == once
    node = nbformat.reads(once, as_version=4)
    assert normalise.dumps(normalise.normalise(json.loads(nbformat.writes(node)))) == once


def test_the_command_checks_and_rewrites(tmp_path, capsys):
    path = tmp_path / "a.ipynb"
    path.write_text(json.dumps({"cells": [code("x", outputs=[PNG])], "nbformat": 4, "nbformat_minor": 5}))
    assert normalise.main(["--check", str(path)]) == 1
    assert "not in stored form" in capsys.readouterr().out
    assert normalise.main([str(path)]) == 0
    assert normalise.main(["--check", str(path)]) == 0
    assert path.read_text().endswith("}\n")
    assert "image" not in path.read_text()


@pytest.mark.parametrize(
    "text", ['{"cells": [', "", "[" * 10**5, "7", "{}", '{"cells": [7]}', '{"cells": [{"cell_type": "code"}]}']
)
def test_a_broken_file_is_named_by_every_tool_with_the_way_to_a_whole_one(tmp_path, capsys, text):
    path = tmp_path / "05-torn.ipynb"
    path.write_text(text)
    with pytest.raises(
        ValueError, match=r"torn\.ipynb is not a notebook .*: restore it with git, or from a fresh copy"
    ):
        normalise.read(path)
    for tool in (normalise.main, execute.main, lint.main, lint_numbers.main, handin.main, edition.main):
        assert tool([str(path)]) == 1
        assert str(path) in capsys.readouterr().err
