"""Show the solution of an exercise, on demand: `python run.py solution 3.1`, or `solution("3.1")` in a notebook."""

import re
import sys

from book.chapters import normalise
from book.chapters.cells import is_code, source, tags
from book.chapters.student import title
from book.setup import names
from book.setup.paths import Stop, in_a_sentence


def found(number):
    """The kind of cell and the text of a solution. Raises `Stop` where there is none of this number."""
    parts = re.fullmatch(r"\D*(\d+)\.(\d+)\D*", str(number).strip())
    if parts is None:
        raise Stop(f"{number!r} is no exercise; they are numbered by chapter, such as 3.1.")
    wanted = f"{int(parts[1])}.{int(parts[2])}"
    cells = normalise.read(names.chapter(parts[1]))["cells"]
    numbers, exercise, texts, kind = [], "", [], "code"
    for cell in cells:
        if "exercise" in tags(cell):
            exercise = re.search(r"\d+\.\d+|$", title(source(cell)))[0]
            numbers.append(exercise)
        elif "solution" in tags(cell) and exercise == wanted:
            kind = "code" if is_code(cell) else "markdown"
            texts.append(source(cell))
    if not texts:
        raise Stop(f"Chapter {int(parts[1])} has no exercise {wanted}; it has {', '.join(numbers) or 'none'}.")
    if "TODO" in texts[0]:
        raise Stop("This edition of the book holds no solutions; ask your teacher.")
    return kind, "\n\n".join(texts)


@in_a_sentence
def main(argv):
    if len(argv) != 1:
        raise Stop("Of which exercise? For example: python run.py solution 3.1")
    print(found(argv[0])[1])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
