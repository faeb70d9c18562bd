"""Store notebooks in one form, so that a diff shows only what an author changed.

Kept: text, LaTeX and plain HTML outputs, with their execution count. Dropped: images, widget views and
states, scripts, timings, metadata of the editor, slide types that a heading says already. Cells without an id get
one. Normalising twice changes nothing.

    python -m book.chapters.normalise notebooks/*.ipynb            # rewrite in place
    python -m book.chapters.normalise --check notebooks/*.ipynb    # only say which would change
"""

import argparse
import hashlib
import json
import re
import sys
from pathlib import Path

from book.chapters.cells import default_slide_type, slide_type, text_of
from book.setup import names
from book.setup.paths import NOTEBOOKS as NOTEBOOKS  # the tools that read chapters take it from here
from book.setup.paths import WORK, Stop, in_a_sentence, whole

KERNELSPEC = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
LANGUAGE = {
    "file_extension": ".py",
    "mimetype": "text/x-python",
    "name": "python",
    "pygments_lexer": "ipython3",
}
CELL_METADATA = ("mystnb", "slideshow", "tags")
PICTURE_TYPES = ("image/", "video/", "application/vnd.jupyter.widget", "application/vnd.omx", "application/javascript")
PICTURE_HTML = ("<script", "<iframe", "<img", "<canvas", "<video", "<svg")


def lines_of(text):
    """The list of lines, ends kept, that the format stores for a multi-line string."""
    return re.sub(r"\r+\n", "\n", text).splitlines(keepends=True)


def is_picture(output):
    """Is this output a figure, a widget or a scene, whose bytes are no text to keep or compare?"""
    data = output.get("data", {})
    if any(mime.startswith(PICTURE_TYPES) for mime in data):
        return True
    return any(mark in text_of(data.get("text/html", "")).lower() for mark in PICTURE_HTML)


def clean_output(output):
    """One output without metadata; an error keeps its name and message, not its traceback with paths."""
    kind = output["output_type"]
    if kind == "stream":
        return {"name": output["name"], "output_type": kind, "text": lines_of(text_of(output["text"]))}
    if kind == "error":
        message = f"{output['ename']}: {output['evalue']}"
        return {
            "ename": output["ename"],
            "evalue": output["evalue"],
            "output_type": kind,
            "traceback": [message],
        }
    cleaned = {"data": clean_data(output["data"]), "metadata": {}, "output_type": kind}
    if kind == "execute_result":
        cleaned["execution_count"] = None  # clean_cell numbers it
    return cleaned


def clean_data(data):
    """A MIME bundle with its texts as lists of lines; JSON types stay as they are."""
    return {mime: value if "json" in mime else lines_of(text_of(value)) for mime, value in data.items()}


def clean_outputs(outputs):
    """What of a cell's outputs is stored: no pictures, neighbouring pieces of one stream joined."""
    kept = join_streams([clean_output(output) for output in outputs if not is_picture(output)])
    return [{**output, "text": lines_of(output["text"])} if "text" in output else output for output in kept]


def join_streams(outputs):
    """The outputs with neighbouring pieces of one stream joined into one string: where they were cut is chance."""
    kept = []
    for output in outputs:
        if "name" in output:
            output = {**output, "text": text_of(output["text"])}
        if kept and "name" in output and kept[-1].get("name") == output["name"]:
            kept[-1]["text"] += output["text"]
        else:
            kept.append(output)
    return kept


def cell_keys(metadata):
    """The metadata of a cell that is stored; graded cells of a student's sheet keep the grader's, and their fold."""
    return (*CELL_METADATA, "nbgrader", "jupyter") if "nbgrader" in metadata else CELL_METADATA


def clean_cell(cell, count):
    """One cell in stored form; `count` is its place among the code cells, from 1."""
    kind = cell["cell_type"]
    metadata = cell.get("metadata", {})
    cleaned = {
        "cell_type": kind,
        "metadata": {key: metadata[key] for key in cell_keys(metadata) if metadata.get(key)},
        "source": lines_of(text_of(cell["source"]).rstrip("\n")),
    }
    if cell.get("attachments"):
        cleaned["attachments"] = cell["attachments"]
    if slide_type(cell) == default_slide_type(cell):
        cleaned["metadata"].pop("slideshow", None)
    if kind == "code":
        if "hide-input" in cleaned["metadata"].get("tags", ()):  # the site folds by the tag, JupyterLab by this
            cleaned["metadata"]["jupyter"] = {"source_hidden": True}
        cleaned["outputs"] = clean_outputs(cell.get("outputs", []))
        cleaned["execution_count"] = count if cleaned["outputs"] else None
        for output in cleaned["outputs"]:
            if "execution_count" in output:
                output["execution_count"] = count
    return cleaned


def cell_id(cell, given, taken):
    """The id that the cell has, so that a typo is one changed line; a short new one where it has none of its own."""
    text = cell["cell_type"] + "\0" + "".join(cell["source"])
    base = given if re.fullmatch(r"[\w-]{1,64}", given or "") else hashlib.sha256(text.encode()).hexdigest()[:10]
    number = 1
    while (name := base if number == 1 else f"{base}-{number}") in taken:
        number += 1
    taken.add(name)
    return name


def normalise(notebook):
    """The notebook (parsed JSON, nbformat 4) in stored form, as a new dict."""
    if notebook.get("nbformat") != 4:
        raise ValueError(f"nbformat 4 is wanted, this notebook has {notebook.get('nbformat')!r}")
    cells, taken, count = [], set(), 0
    for cell in notebook["cells"]:
        count += cell["cell_type"] == "code"
        cleaned = clean_cell(cell, count)
        cleaned["id"] = cell_id(cleaned, cell.get("id"), taken)
        cells.append(cleaned)
    metadata = {"kernelspec": KERNELSPEC, "language_info": LANGUAGE}
    return {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}


def dumps(notebook):
    """The one text of a notebook: sorted keys, indent 1, UTF-8, one newline at the end."""
    return json.dumps(notebook, indent=1, sort_keys=True, ensure_ascii=False) + "\n"


class Damaged(Stop, ValueError):
    """A file that is no notebook: which, why, and how to get one in its place."""

    def __init__(self, path, why):
        path = Path(path)
        again = f"`python run.py reset {path.name[:2]}` gives the chapter out again, and keeps this file"
        fresh = "restore it with git, or from a fresh copy of the book"
        super().__init__(f"{path} is not a notebook ({why}): {again if path.parent == WORK else fresh}.")


def read(path):
    """The parsed JSON of a notebook file; `Damaged` where it is not a notebook."""
    try:
        notebook = json.loads(Path(path).read_text(encoding="utf-8"))
        _ = [(cell["cell_type"], text_of(cell["source"])) for cell in notebook["cells"]]
    except (ValueError, RecursionError) as error:
        raise Damaged(path, error) from error
    except (KeyError, TypeError) as error:
        raise Damaged(path, "its cells are not whole") from error
    return notebook


def write(path, notebook):
    """Write the notebook whole or not at all; True when the file changed."""
    path, text = Path(path), dumps(notebook)
    if path.exists() and path.read_bytes() == text.encode():
        return False
    with whole(path) as partial:
        partial.write_text(text, encoding="utf-8", newline="\n")
    return True


def chapters(arguments):
    """The notebook paths that a command line names, each as `names.chapter` has it; all when it names none."""
    try:
        return [names.chapter(name) for name in arguments] or names.chapters()
    except Stop as stop:
        sys.exit(f"run.py: {stop}")


@in_a_sentence
def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("notebooks", nargs="*", help="default: every chapter")
    parser.add_argument("--check", action="store_true", help="change nothing; exit 1 when something would")
    options = parser.parse_args(argv)
    changed = 0
    for path in chapters(options.notebooks):
        notebook = normalise(read(path))
        stale = dumps(notebook) != path.read_text(encoding="utf-8")
        if stale:
            changed += 1
            print(f"{path}: {'is not in stored form' if options.check else 'normalised'}")
            if not options.check:
                write(path, notebook)
    return 1 if options.check and changed else 0


if __name__ == "__main__":
    sys.exit(main())
