"""JupyterLite: Python in the browser tab runs SymPy, and no request leaves the machine."""

from urllib.parse import quote

import pytest

from book.publish import lite
from book.setup.paths import Stop
from tests.browser.weblook import served

CODE = "import sympy; x = sympy.Symbol('x'); print(sympy.factor(x**4 - 1), sympy.__version__)"


@pytest.fixture(scope="module")
def home():
    try:
        lite.build()
    except Stop as stop:
        pytest.skip(str(stop))
    with served(lite.LITE) as address:
        yield address


def test_sympy_runs_in_the_browser_and_nothing_leaves(look):
    look.open(f"repl/index.html?kernel=python&execute=1&code={quote(CODE)}")
    output = look.page.locator(".jp-OutputArea-output", has_text="(x - 1)*(x + 1)*(x**2 + 1)")
    output.first.wait_for(timeout=240_000)
    assert [problem for problem in look.problems if problem.startswith("request leaves")] == []


def test_the_chapters_without_a_bus_are_there_as_sheets():
    names = {path.name[:2] for path in (lite.SOURCE / "files").glob("*.ipynb")}
    assert {"00", "01", "03"} <= names
    assert not names & set(lite.NEEDS_A_BUS)


def test_what_the_builder_needs_is_pinned():
    for name in lite.EXTRA:
        assert name == "omx" or lite.pinned(name)
