"""What JupyterLab stores when it saves: nothing of a run that is dead on the next day or dirties a checkout.

A chapter in notebooks/ is stored in the book's one form; a copy in work/ keeps its texts and figures. Widgets cannot
come back without their kernel: where one was, a line says how to see it again.
"""

from pathlib import Path

from book.chapters import normalise
from book.setup.paths import NOTEBOOKS, WORK

AGAIN = "Run this cell (Shift+Enter) to see it move."
WIDGET = "application/vnd.jupyter.widget-view+json"


def before_saving(model, path, contents_manager, **_):
    """A pre-save hook of Jupyter's contents manager."""
    content = model.get("content")
    if model["type"] != "notebook" or not isinstance(content, dict) or content.get("nbformat") != 4:
        return
    folder = Path(contents_manager.root_dir, path).parent.resolve()
    if folder == NOTEBOOKS.resolve():
        model["content"] = normalise.normalise(content)
    elif folder == WORK.resolve():
        model["content"] = kept(content)


def kept(notebook):
    """A reader's notebook as it is stored: without counts, widgets and what the editor notes for itself."""
    cells = [{**cell, **run_of(cell)} if cell["cell_type"] == "code" else cell for cell in notebook["cells"]]
    metadata = {"kernelspec": normalise.KERNELSPEC, "language_info": normalise.LANGUAGE}
    return {**notebook, "cells": cells, "metadata": metadata}


def run_of(cell):
    """The outputs of a code cell that outlive their kernel, uncounted; one line for its widgets."""
    outputs, is_told = [], False
    for output in cell.get("outputs", []):
        if WIDGET not in output.get("data", {}):
            outputs.append({**output, "execution_count": None} if "execution_count" in output else output)
        elif not is_told:
            outputs.append({"output_type": "display_data", "metadata": {}, "data": {"text/plain": AGAIN}})
            is_told = True
    metadata = {name: value for name, value in cell["metadata"].items() if name != "execution"}
    return {"outputs": outputs, "execution_count": None, "metadata": metadata}
