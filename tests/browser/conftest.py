"""One JupyterLab and one browser for all browser tests; notebooks are copies in a scratch folder."""

import json
import os
import shutil
import urllib.request
from unittest import mock

import pytest
from playwright.sync_api import sync_playwright

from book.chapters import normalise
from tests.browser.pages import NotebookPage
from tests.browser.weblook import Look, served
from tests.helpers.lab import running_lab

#: The last one: nothing but this machine has an address.
FLAGS = (
    *("--headless", "--disable-gpu", "--enable-unsafe-swiftshader", "--no-sandbox", "--disable-quic"),
    *("--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"),
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
)


@pytest.fixture(scope="session")
def playwright():
    """There can be one in a process."""
    with sync_playwright() as playwright:
        yield playwright


@pytest.fixture(scope="session")
def browser(playwright, chromium):
    browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
    yield browser
    browser.close()


@pytest.fixture(scope="session")
def lab(chromium, tmp_path_factory):
    """JupyterLab on copies of the chapters; what they generate goes to `lab.generated`, under another hash seed."""
    root = tmp_path_factory.mktemp("book")
    shutil.copytree(normalise.NOTEBOOKS, root / "notebooks", ignore=shutil.ignore_patterns(".*"))
    generated = tmp_path_factory.mktemp("generated")
    other = mock.patch.dict(os.environ, OMX_GENERATED=str(generated), PYTHONHASHSEED="4242")
    with other, running_lab(tmp_path_factory.mktemp("lab"), root=root) as lab:
        lab.root, lab.generated = root, generated
        yield lab


@pytest.fixture(scope="module")
def window():
    """Width and height of the pages (px); a module of tests may have its own."""
    return 1300, 1000


@pytest.fixture(scope="module")
def motion():
    """Do films play by themselves? A module of tests that looks at none says "reduce": the film on its page stands."""
    return "no-preference"


@pytest.fixture(scope="module")
def sharpness():
    """Pixels drawn for each px of the page; a module of tests that only asks whether something moves takes fewer."""
    return 1


@pytest.fixture(scope="module")
def context(browser, window, motion, sharpness):
    width, height = window
    size = {"viewport": {"width": width, "height": height}, "device_scale_factor": sharpness}
    context = browser.new_context(**size, reduced_motion=motion)
    context.new_page()  # it stays: without a page Chromium closes the window, and the next one costs half a second
    yield context
    context.close()


@pytest.fixture(scope="module")
def home(built_site):
    """The address of the site, built from what is here now; a module of tests may have its own."""
    with served(built_site) as address:
        yield address


@pytest.fixture
def look(context, home):
    """A page of what is at `home`."""
    with Look(context, home) as look:
        yield look


@pytest.fixture(scope="module")
def sound():
    """The JupyterLab page in which the last test passed, if it did: the next notebook is opened there."""
    return []


@pytest.fixture
def open_page(context, lab, sound, request):
    """Open a notebook of the scratch folder; it and its kernel end with the test, and after a failure the page does."""
    pages, failed = [], request.session.testsfailed

    def opener(path):
        pages.append(sound.pop().go_on_to(path) if sound else NotebookPage(context, lab, path))
        return pages[-1]

    yield opener
    for page in pages:
        if request.session.testsfailed == failed and not sound and page.leave():
            sound.append(page)
        else:
            page.close()
    end_kernels(lab)


def end_kernels(lab):
    for kernel in lab.ask("kernels"):
        address = f"{lab.url}/api/kernels/{kernel['id']}"
        request = urllib.request.Request(address, headers={"Authorization": f"token {lab.token}"}, method="DELETE")
        urllib.request.urlopen(request, timeout=30).close()


@pytest.fixture
def notebook(lab, request):
    """Write a notebook of code cells into the scratch folder; returns its path."""

    def write(*cells, name="scratch"):
        path = lab.root / f"{request.node.name.split('[')[0]}-{name}.ipynb"
        kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
        sources = [
            {"cell_type": "code", "id": f"c{i}", "metadata": {}, "source": cell, "outputs": [], "execution_count": None}
            for i, cell in enumerate(cells)
        ]
        content = {"cells": sources, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
        path.write_text(json.dumps(content), encoding="utf-8")
        return path

    return write
