"""What a reader waits for: the weight of the site's pages, and the time from a slider to the drawn arm."""

import contextlib
import shutil
import statistics
import tempfile
from pathlib import Path

from book.publish import site
from tests.bench.sheet import Expectation, Panel, Section, Size, Table, at_most

PROSE = """Pages were opened in Chromium from the loopback address; a page's own weight leaves out the viewer and
MathJax, which all pages share and the browser keeps. For the slider, a key was pressed in JupyterLab with a live
kernel, and the time to the drawn scene compared with the bare round trip of a message in the same page."""

TWICE, P95_MS = 2.0, 80.0


def measure(size: Size, built: Path) -> Section:
    """`built`: the folder of a site, if there is one."""
    section = Section("The book: pages and sliders", PROSE)
    try:
        from playwright.sync_api import sync_playwright

        from book.publish.handout import NAMES
        from tests.browser.conftest import FLAGS
    except ImportError as error:
        section.left_out.append(f"everything: {error}")
        return section
    chromium = next(filter(None, map(shutil.which, NAMES)), None)
    if chromium is None:
        section.left_out.append("everything: no Chromium on this machine")
        return section
    with sync_playwright() as playwright, playwright.chromium.launch(executable_path=chromium, args=FLAGS) as browser:
        for part in (_weights, _slider):
            try:
                part(section, size, browser, built)
            except Exception as error:  # a browser fails in its own ways; the rest of the report stands
                section.left_out.append(f"{part.__name__[1:]}: {type(error).__name__}: {str(error).splitlines()[0]}")
    return section


def _weights(section: Section, size: Size, browser, built: Path) -> None:
    from tests.browser.test_site import LIMIT, SHARED, pages
    from tests.browser.weblook import Look, served

    if not (built / "book" / "index.html").exists():
        section.left_out.append("weights: there is no site; `python run.py book` builds it")
        return
    own, shared = {}, {}
    context = browser.new_context(viewport={"width": 1280, "height": 860})
    wanted = sorted((path for path in pages() if (built / path).exists()), key=lambda path: "notebooks" not in path)
    with served(built) as home:
        for path in wanted if size.whole else wanted[:1]:
            with Look(context, home) as look:
                weight = look.open(path).settle() or look.weight()
            own[path] = sum(value for name, value in weight.items() if name not in SHARED)
            shared |= {name: value for name, value in weight.items() if name in SHARED}
    context.close()
    _show_weights(section, own, shared, LIMIT, size)


def _show_weights(section: Section, own: dict, shared: dict, limit: int, size: Size) -> None:
    rows = [(path, f"{value / 1e6:.2f} MB") for path, value in sorted(own.items(), key=lambda item: -item[1])]
    rows += [(f"shared: {name}", f"{value / 1e6:.2f} MB") for name, value in shared.items()]
    title = "Weight of the pages" if size.whole else "Weight of a page of the site that was there"
    section.tables.append(Table(title, ("page", "weight"), rows))
    heaviest = max(own, key=own.get)
    what = f"the heaviest of {len(own)} pages, {heaviest}"
    section.expectations.append(at_most(what, own[heaviest] / 1e6, limit / 1e6, " MB"))
    chapters = {Path(path).stem: value / 1e6 for path, value in own.items() if path.startswith("notebooks/")}
    if chapters:
        section.panels.append(Panel("Pages of the chapters", "own weight (MB)", "", {}, chapters, limit / 1e6))


def _slider(section: Section, size: Size, browser, _) -> None:
    if not size.whole:
        section.left_out.append("sliders: --quick")
        return
    import nbformat

    from tests.browser.latency import PANEL, PROBE, latencies, percentile, summary
    from tests.browser.pages import NotebookPage
    from tests.helpers.lab import running_lab

    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        (folder / "notebooks").mkdir()
        path = folder / "notebooks" / "slider.ipynb"
        code = [nbformat.v4.new_code_cell(source) for source in (PANEL, PROBE)]
        kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
        nbformat.write(nbformat.v4.new_notebook(cells=code, metadata={"kernelspec": kernel}), path)
        lab = stack.enter_context(running_lab(folder, root=folder))
        lab.root = folder
        page = NotebookPage(browser.new_context(viewport={"width": 1300, "height": 1000}), lab, path)
        page.run_all()
        found = latencies(page, size.presses)
    middle = {name: statistics.median(values) for name, values in found.items()}
    words = {"message": "a message there and back", "slider": "a slider without an arm", "arm": "slider to drawn arm"}
    rows = [(words[name], summary(values)) for name, values in found.items()]
    section.tables.append(Table(f"Slider, {size.presses} presses", ("", "time"), rows))
    section.expectations += [
        at_most("slider to drawn arm, median, of a message's round trip", middle["arm"] / middle["message"], TWICE),
        _within("slider to drawn arm, 95 in 100", percentile(found["arm"]), P95_MS),
    ]


def _within(what: str, measured_ms: float, limit_ms: float) -> Expectation:
    return Expectation(what, f"<= {limit_ms:g} ms", f"{measured_ms:.0f} ms", measured_ms <= limit_ms)


#: Where the site is, if it was built before.
THERE = site.SITE
