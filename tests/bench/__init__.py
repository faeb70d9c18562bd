"""How fast is it? `python -m tests.bench`: a table, or with --report a report; every ratio is taken in one run."""
