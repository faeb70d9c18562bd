"""How fast is it? `python -m tests.bench [--quick]`: one table, every ratio taken in one run."""
