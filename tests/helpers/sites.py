"""The site and the slides, built once for all tests that look at them."""

import pytest

from book.publish import site
from book.setup.paths import Stop


@pytest.fixture(scope="session")
def built_site():
    """The folder of the site, built from what is here now; skipped where npm or the network is missing."""
    try:
        assert site.build() == 0, "the build ended with a warning or an error"
    except Stop as stop:
        pytest.skip(str(stop))
    return site.SITE
