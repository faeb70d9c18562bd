"""A small chapter that keeps every convention, for the tests of the notebook tools."""


def markdown(source, slide="-", tags=()):
    return {"cell_type": "markdown", "source": source, "metadata": metadata(slide, tags)}


def code(source, slide="-", tags=(), outputs=()):
    cell = {"cell_type": "code", "source": source, "metadata": metadata(slide, tags)}
    return {**cell, "outputs": list(outputs), "execution_count": None}


def metadata(slide, tags):
    return {"slideshow": {"slide_type": slide}, "tags": list(tags)}


def printed(text):
    return {"output_type": "stream", "name": "stdout", "text": text}


PROSE = """A straight line between two corners of a box is the longest side of a triangle with a right angle, and its
length follows from the two other sides alone. That is an old theorem, and it is all that this page needs. We write
the sides as two numbers in millimetres, square them, add the squares and take the root, which gives the **length**
of the line in millimetres again. The next cell does exactly this, and the number that it prints can be checked with
a ruler on squared paper, because the sides were chosen so that every number is whole."""


def chapter():
    """The cells, as parsed JSON; the exercise has a solution of a function and of a variable."""
    return [
        markdown("# Straight lines\n\nA straight line has a length.", "slide"),
        markdown("**You will be able to**\n\n- name a length,\n- compute a length,\n- check a length."),
        markdown(PROSE),
        code("import math", "skip"),
        markdown("## Length\n\n**Predict** how long the line will be before you run the cell.", "slide", ["predict"]),
        markdown("*For the speaker.* **Expect** seven, the sum of the sides.", "notes"),
        code("print(math.hypot(3, 4), 'mm')", outputs=[printed("5.0 mm\n")]),
        markdown("**Play** with the two numbers and watch what changes in the printed length.", tags=["play"]),
        markdown("## Summary\n\nThe length of a line follows from its two sides.", "slide"),
        markdown("## Exercises", "slide"),
        markdown(EXERCISE, "subslide", ["exercise"]),
        code(SOLUTION, "skip", ["solution"]),
        code("assert diagonal(3, 4) == 5 and length == 13\nprint('Right.')", "skip", ["check"], [printed("Right.\n")]),
    ]


EXERCISE = "### Exercise 7.1: another line\n\nSides of 5 and 12. **Hint:** `hypot` does it."
SOLUTION = '''def diagonal(width, height):
    """The diagonal of a box, mm."""
    return math.sqrt(width**2 + height**2)

length = math.hypot(5, 12)'''
