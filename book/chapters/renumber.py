"""Give chapters other numbers: `python -m book.chapters.renumber screws=4 weight=8`; all others close up around them.

File names, titles, links, "chapter 4", "exercise 4.3" and the exercises' own numbers follow in every text of the
repository; in the tests only file names do, since theirs are made up. Other words do not ("session 4: chapters four
to six", a bare "04" in code): read the change before you commit it, then `execute` the chapters.
"""

import re
import subprocess
import sys
from pathlib import Path

from book.chapters import normalise
from book.setup import names
from book.setup.paths import NOTEBOOKS, ROOT, Stop, in_a_sentence

#: Texts that may speak of chapters; what the chapters write is written by them again.
TEXTS = {".md", ".py", ".js", ".ipynb", ".html", ".css", ".toml", ".csv"}
_NUMBERS = r"\d{1,2}(?:\.\d{1,2})?\b(?!-|\.\d)"
#: What stands before a number: "chapters 3, 4 and 5", "exercise 4.3", `variant("4.3")`, `lab 03`, "# 4 · Title".
_BEFORE = "|".join((
    r"\b(?:chapters?|exercises?)\s+", r"\bvariant\(\"", r"\bsolution(?:\(\"|\s)", r"^# (?=\d{1,2} · )", "--graded ",
    r"run\.py (?:lab|reset|handin|check|execute) ", r"\[(?=[^\]\n]*\]\([^)\n]*\b\d\d-[a-z-]+\.ipynb)",
))  # fmt: skip
_LIST = rf"{_NUMBERS}(?:(?:, {_NUMBERS})*(?:,? (?:and|to|or) |–){_NUMBERS})?"
_REFERENCE = re.compile(f"({_BEFORE})({_LIST})", re.IGNORECASE | re.MULTILINE)


def moved(chapters, places):
    """The stems of `chapters`, such as "04-inverse-kinematics", in a new order: `places` maps some to their number."""
    order = [stem for stem in chapters if stem not in places]
    for stem in sorted(places, key=places.get):
        order.insert(places[stem], stem)
    return order


class Renumbering:
    """New numbers for the chapters whose stems, in the new order, are `order`."""

    def __init__(self, order):
        self.stems = {stem: f"{number:02}-{stem[3:]}" for number, stem in enumerate(order)}
        self.numbers = {int(stem[:2]): number for number, stem in enumerate(order)}
        self._names = re.compile(rf"\b({'|'.join(map(re.escape, sorted(self.stems, reverse=True)))})\b")

    def number(self, text):
        """The new form of "4", "04" or "4.3"; as it is where no chapter has that number."""
        chapter, dot, exercise = text.partition(".")
        new = self.numbers.get(int(chapter), int(chapter))
        return f"{new:0{len(chapter) if chapter.startswith('0') else 1}}{dot}{exercise}"

    def files(self, text):
        """`text` with the new names of files."""
        return self._names.sub(lambda found: self.stems[found[0]], text)

    def text(self, text):
        """`text` with the new names and numbers."""
        text = self.files(text)
        return _REFERENCE.sub(
            lambda found: found[1] + re.sub(_NUMBERS, lambda number: self.number(number[0]), found[2]), text
        )

    def notebook(self, notebook):
        """A notebook (parsed JSON) with the new names and numbers in the sources of its cells."""
        cells = [{**cell, "source": self.text("".join(cell["source"]))} for cell in notebook["cells"]]
        return normalise.normalise({**notebook, "cells": cells})

    def apply(self, root=ROOT):
        """Change every tracked text below `root`, and the names of the chapters' files."""
        listed = subprocess.run(["git", "ls-files", "-z"], cwd=root, check=True, capture_output=True, text=True).stdout
        for path in sorted(Path(root, name) for name in listed.split("\0") if Path(name).suffix in TEXTS):
            if path == Path(__file__) or not path.is_file():
                continue
            if path.suffix == ".ipynb":
                normalise.write(path, self.notebook(normalise.read(path)))
                continue
            text = path.read_text(encoding="utf-8")
            change = self.files if path.is_relative_to(Path(root, "tests")) else self.text
            if (new := change(text)) != text:
                path.write_text(new, encoding="utf-8", newline="\n")
        folder = Path(root, NOTEBOOKS.relative_to(ROOT))
        for stem in self.stems:  # two steps: a new name may be one that another chapter still has
            Path(folder, f"{stem}.ipynb").rename(folder / f"{stem}.moved")
        for stem, new in self.stems.items():
            Path(folder, f"{stem}.moved").rename(folder / f"{new}.ipynb")


@in_a_sentence
def main(argv):
    places = {}
    for word in argv:
        name, _, number = word.partition("=")
        if not number.isdecimal():
            raise Stop(f"{word!r} must be a chapter and its new number: screws=4.")
        places[names.chapter(name).stem] = int(number)
    if not places:
        raise Stop("Name the chapters that move, and their new numbers: screws=4 weight=8.")
    new = Renumbering(moved([path.stem for path in names.chapters()], places))
    new.apply()
    for old, stem in new.stems.items():
        print(f"{old} -> {stem}" if old != stem else old)
    print("Read the change, and look for bare numbers in code; then `python run.py execute`.")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
