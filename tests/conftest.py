"""What all tests share: the browser and the hub. How chapters are run is in tests/helpers/chapter_runs.py."""

import os
import shutil

import pytest

from book.publish import handout
from book.setup.paths import Stop
from tests.helpers.hub import running_hub
from tests.helpers.sites import built_site  # noqa: F401 - a fixture

ON_CI = bool(os.environ.get("CI"))


# ---- the browser ---------------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def chromium():
    """The path of the system's Chromium; without one browser tests are skipped, on CI they fail."""
    found = next((path for name in handout.NAMES if (path := shutil.which(name))), None)
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
