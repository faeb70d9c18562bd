"""Begin a chapter: `python run.py new-chapter light-and-shadow` writes the skeleton of the next one."""

import re
import sys

from book.chapters import normalise
from book.chapters.execute import execute
from book.setup.paths import NOTEBOOKS, ROOT, Stop, in_a_sentence

#: A question about an earlier chapter, its answer closed.
RECALL = "**{}.** «A question.»\n\n<details><summary>Answer</summary>\n\n«Its answer.»\n\n</details>"

#: The cells of a skeleton: (kind, text, tags). What stands in «...» is the author's to fill; the lint finds the rest.
SKELETON = (
    ("markdown", "# {title}\n\n«One sentence that makes a student want to know.»", ()),
    ("markdown", "You will be able to\n\n- «derive ...»,\n- «compute ...»,\n- «decide ...».", ()),
    ("code", "import numpy as np\n\nimport omx\nfrom omx import View, check", ()),
    ("markdown", "## Before you begin\n\n" + "\n\n".join(RECALL.format(number) for number in (1, 2, 3)), ("recall",)),
    ("markdown", "## «The idea»\n\n«Say it in words, then derive it, then show it in a small cell.»", ()),
    ("code", 'tip = omx.pose(omx.HOME)\nprint(f"x = {{tip.x:.1f}} mm, z = {{tip.z:.1f}} mm")\nassert tip.x > 0', ()),
    ("markdown", "«Read the number back, with its unit.»", ()),
    ("markdown", "**Predict.** «A question before a surprise.»", ("predict",)),
    ("notes", "*For the speaker.* **Expect** «the wrong answer that most will give, and what to ask then».", ()),
    ("markdown", "**Play.** «What to try, and what to look for.»", ("play",)),
    ("code", "View()", ("play",)),
    ("markdown", "## On the arm\n\n«The same on the virtual arm, or on yours.»", ("on-the-arm",)),
    ("markdown", "## Summary\n\n- «The one idea.»", ()),
    ("markdown", "## Exercises", ()),
    ("markdown", "### Exercise {number}.1: «its name»\n\n*Difficulty 2 of 5, about 10 minutes.*\n\n"
     "«The task.»\n\n**Hint:** «a step, no answer.»", ("exercise",)),
    ("code", "reach = float(np.hypot(*omx.pose(omx.HOME)[:2]))", ("solution",)),
    ("code", 'check.value(reach, omx.pose(omx.HOME).x, "the reach", "mm")', ("check",)),
)  # fmt: skip


def new(name):
    """Write the skeleton of the next chapter, run it, and return its path. Raises `Stop`."""
    if not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name):
        raise Stop(f"{name!r} must be words in small letters, joined by hyphens: light-and-shadow.")
    number = max(int(path.name[:2]) for path in NOTEBOOKS.glob("[0-9][0-9]-*.ipynb")) + 1
    path = NOTEBOOKS / f"{number:02}-{name}.ipynb"
    title = name.replace("-", " ").capitalize()
    cells = [cell(kind, text.format(title=title, number=number), tags) for kind, text, tags in SKELETON]
    normalise.write(path, normalise.normalise({"cells": cells, "nbformat": 4}))
    execute(path)
    return path


def cell(kind, text, tags):
    if kind == "notes":
        return {"cell_type": "markdown", "source": text, "metadata": {"slideshow": {"slide_type": "notes"}}}
    made = {"cell_type": kind, "source": text, "metadata": {"tags": list(tags)} if tags else {}}
    return made | ({"outputs": [], "execution_count": None} if kind == "code" else {})


@in_a_sentence
def main(argv):
    if len(argv) != 1:
        raise Stop("Name its topic, such as light-and-shadow.")
    path = new(argv[0]).relative_to(ROOT)
    number = path.name[:2]
    print(f"{path} is there. `python run.py check {number}` says what is left to do, `lab --author {number}` opens it.")
    print("At the end: a line in README.md, and one in CHANGELOG.md.")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
