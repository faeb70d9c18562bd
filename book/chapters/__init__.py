"""Tools that make and check the notebooks: `python -m book.chapters.NAME`."""

import sys

# Importing nbformat imports jsonschema, which compiles 38 grammars for checkers of web addresses that no notebook
# asks for: two to four seconds at every start. It does without this package where it is not installed.
sys.modules.setdefault("rfc3987_syntax", None)
