"""The reader's side of the book: a folder `work/` of their own, its updates, solutions on demand, a file to hand in.

In a notebook: `from book.reader import contents, solution`.
"""


def contents():
    """The chapters, each with its sentence and how many of its exercises are done, as a table in a notebook."""
    from IPython.display import Markdown

    from book.reader import overview
    from book.setup.paths import WORK

    return Markdown(overview.table(WORK))


def solution(number):
    """The solution of an exercise such as "3.1", as code that a notebook shows in colours."""
    from IPython.display import Code, Markdown

    from book.reader import solutions

    kind, text = solutions.found(number)
    return Code(text, language="python") if kind == "code" else Markdown(text)
