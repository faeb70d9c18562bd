"""Everything about code and chapters that can be checked in seconds: `python run.py check [chapter ...]`.

Without a chapter: ruff over the whole repository, notebooks too, the types of the mathematics (mypy), then the
conventions of every chapter, and the numbers of the pages that tell some.
"""

import subprocess
import sys

from book.chapters import lint, lint_numbers
from book.setup.paths import ROOT, in_a_sentence


@in_a_sentence
def check(arguments):
    """Print each complaint; the exit status. `arguments`: chapters as `03`, file names or paths; all if empty."""
    paths = lint.chapters(arguments)
    command = [sys.executable, "-m", "ruff", "check", "--output-format=concise", *(paths if arguments else ["."])]
    style = subprocess.run(command, cwd=ROOT, check=False).returncode
    if not arguments:
        style += subprocess.run([sys.executable, "-m", "mypy", "--no-error-summary"], cwd=ROOT, check=False).returncode
    found = [problem for path in paths for problem in lint.problems(path)]
    found += [] if arguments else lint_numbers.of_pages()
    print("\n".join(found) or "The chapters keep the conventions.")
    return int(bool(style or found))


if __name__ == "__main__":
    sys.exit(check(sys.argv[1:]))
