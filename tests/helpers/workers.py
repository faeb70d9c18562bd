"""A pytest plugin: the order of the tests, and how several processes share them (`-n 2`, as `run.py test` does).

The chapters come first: all others use their runs. The browser tests come last: Playwright keeps an event loop
running, in which no other can be started. A file of tests stays with one process, and so do the files that share
what takes long to make.
"""

import re

from xdist.scheduler import LoadFileScheduling

#: By what they share, in this order: the built pages and decks in one browser, one JupyterLab in another.
TOGETHER = {
    "site": re.compile(r"tests/book/test_site|tests/browser/test_(site|slides|accessibility|lite|edit_line)\b"),
    "lab": re.compile(r"tests/browser/"),
}


def group(path):
    """The name of what a file of tests (its path in the repository) shares with others, else the file itself."""
    return next((name for name, files in TOGETHER.items() if files.match(path)), path)


def place(path):
    """Chapters, then what stands alone, then each group."""
    name = group(path)
    return [*TOGETHER].index(name) + 1 if name in TOGETHER else -name.endswith(".ipynb")


class InGroups(LoadFileScheduling):
    """Whole groups of tests, one after the other, to whichever process is free."""

    def _split_scope(self, nodeid):
        return group(super()._split_scope(nodeid))


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: place(item.nodeid.partition(":")[0]))


def pytest_xdist_make_scheduler(config, log):
    config.option.loadscopereorder = False
    return InGroups(config, log)
