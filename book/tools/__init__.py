"""Tools that make and check the notebooks: `python -m book.tools.NAME`."""
