"""What all tests share: generated modules go to a scratch folder, notebooks are compared as they are stored."""

import os
import shutil
import tempfile

import nbval.plugin
import pytest

from book.setup.paths import Stop
from tests.helpers import chapter_runs
from tests.helpers.hub import running_hub
from tests.helpers.sites import built_site  # noqa: F401 - a fixture

ON_CI = bool(os.environ.get("CI"))
CHROMIUM_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")


def pytest_configure(config):
    """Keep the checked-in modules out of every notebook's reach, and let kernels keep their bytecode."""
    config.generated = tempfile.TemporaryDirectory(prefix="omx-generated-")
    os.environ["OMX_GENERATED"] = config.generated.name
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


def pytest_unconfigure(config):
    os.environ.pop("OMX_GENERATED", None)
    config.generated.cleanup()


def pytest_collection_modifyitems(items):
    """Let nbval look at every cell, and give a kernel on a busy machine time to say what it printed.

    The chapters come first: all others use their runs. The browser tests come last: Playwright keeps an event loop
    running, in which no other can be started.
    """
    items.sort(key=lambda item: ("browser" in item.path.parts) - (item.path.suffix == ".ipynb"))
    for item in items:
        if isinstance(item, nbval.plugin.IPyNbCell):
            item.output_timeout = 30
            if item.cell.execution_count is None and not item.cell.outputs:
                item.cell.execution_count = 0  # stored without outputs, so it must have none; nbval would skip it


chapter_runs.install()


# ---- the browser ---------------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def chromium():
    """The path of the system's Chromium; without one browser tests are skipped, on CI they fail."""
    found = next((path for name in CHROMIUM_NAMES if (path := shutil.which(name))), None)
    if not found and ON_CI:
        pytest.fail("No Chromium on this machine; on CI the browser tests must run (.ci/run installs it).")
    if not found:
        pytest.skip("No Chromium on this machine: install chromium to run the browser tests.")
    return found


@pytest.fixture(scope="module")
def hub():
    """A JupyterHub with the book's settings; skipped where it cannot be installed, but not on CI."""
    try:
        with running_hub() as hub:
            yield hub
    except Stop as stop:
        (pytest.fail if ON_CI else pytest.skip)(str(stop))
