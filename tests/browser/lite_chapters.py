"""Every chapter in the browser's Python, cell by cell against its stored outputs: `python run.py test lite`.

A plain static server, the network cut, no Python but the tab's. It takes minutes, so the ordinary tests leave it out.
What may differ, and why, is listed in `lite_differences.json`.
"""

import json
from pathlib import Path
from unittest import mock

import pytest

from book.chapters import cells, normalise
from book.publish import lite, runs
from tests.browser.weblook import served
from tests.helpers.lite import chapter, run_all, texts

DIFFERENCES = json.loads(Path(__file__).with_name("lite_differences.json").read_text(encoding="utf-8"))
CHAPTERS = [path.name for path in runs.chapters()]


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    root = tmp_path_factory.mktemp("lite")
    with mock.patch.multiple(lite, SOURCE=root / "source", LITE=root / "lite"):
        lite.build(solutions=True)
    with served(root / "lite") as address:
        yield address


@pytest.mark.parametrize("name", CHAPTERS)
def test_a_chapter_prints_in_the_browser_what_is_stored(name, home, playwright, chromium, capsys):
    with chapter(playwright, chromium, home, name) as tab:
        done, took = run_all(tab)
    stored = normalise.read(normalise.NOTEBOOKS / name)["cells"]
    code = [(here, there) for here, there in zip(done[1:], stored, strict=True) if cells.is_code(there)]
    ran = sum(bool(here["execution_count"]) for here, _ in code)
    differing = {there["id"]: (texts(here), texts(there)) for here, there in code if differs(here, there)}
    with capsys.disabled():
        print(f"\n{name}: {ran} of {len(code)} cells, {len(differing)} differ;", end=" ")
        print(f"kernel ready in {tab.ready_s:.0f} s, run in {took:.0f} s;", end=" ")
        print(f"{len(tab.outside)} requests to others, complaints: {set(tab.complaints) or 'none'}")
    assert failures(code) == []
    assert ran == len(code)
    accepted = DIFFERENCES.get(name[3:].removesuffix(".ipynb"), {})
    assert {key: value for key, value in differing.items() if key not in accepted} == {}
    assert set(accepted) <= set(differing), "a difference that is gone is still listed"
    assert tab.outside == []


def failures(code):
    """Cells that end with an error which the chapter does not mean to show."""
    return [
        (there["id"], output["ename"], output["evalue"][:300])
        for here, there in code
        if "raises-exception" not in cells.tags(there)
        for output in here["outputs"]
        if output["output_type"] == "error"
    ]


def differs(here, there):
    return "nbval-ignore-output" not in cells.tags(there) and texts(here) != texts(there)
