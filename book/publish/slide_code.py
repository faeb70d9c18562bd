"""Code as it stands on a slide: in lines short enough for large type, marked where it may go on on another slide.

A chapter's lines hold 120 characters, a slide's `COLUMNS`. Remarks behind longer lines go above them, then ruff lays
the code out anew: the same statements, in more lines.
"""

import ast
import io
import json
import re
import subprocess
import sys
import textwrap
import tokenize

from book.chapters import cells

#: Characters of a line that fill a slide in type of 26 of 720 pixels (`deck.css`).
COLUMNS = 72
#: Lines that a slide holds in that type, below a heading and a sentence.
MOST_LINES = 12
FORMAT = (sys.executable, "-m", "ruff", "format", "--isolated", "--line-length", str(COLUMNS))


def narrowed(notebook):
    """A copy of the notebook (parsed JSON) whose code has lines for a slide."""
    copied = json.loads(json.dumps(notebook))
    code = [cell for cell in copied["cells"] if cells.is_code(cell)]
    bare = {"cells": [], "metadata": {}, "nbformat": 4, "nbformat_minor": 5}
    for cell in code:
        source = remarks_above(cells.source(cell))
        bare["cells"].append({**cell, "source": source, "metadata": {}, "outputs": [], "execution_count": None})
    command = [*FORMAT, "--stdin-filename", "chapter.ipynb", "-"]
    done = subprocess.run(command, input=json.dumps(bare), capture_output=True, check=True, encoding="utf-8")
    for cell, short in zip(code, json.loads(done.stdout)["cells"], strict=True):
        cell["metadata"]["lines"] = len(cells.code_lines(cell))  # as written: how long they take
        cell["source"] = re.sub(r"\n{3,}", "\n\n", cells.source(short))
    return copied


def remarks_above(source):
    """Code in which a remark behind a line that is too long stands above it, in lines that fit."""
    lines = source.splitlines()
    for token in reversed(list(tokenize.generate_tokens(io.StringIO(source).readline))):
        row, column = token.start
        line = lines[row - 1] if token.type == tokenize.COMMENT else ""
        if len(line) > COLUMNS:
            before = line[:column].rstrip()
            indent = line[: len(line) - len(line.lstrip())]
            words = textwrap.wrap(token.string.lstrip("# "), COLUMNS - len(indent) - 2)
            lines[row - 1 : row] = [*(f"{indent}# {part}" for part in words), *([before] if before else [])]
    return "\n".join(lines)


def beginnings(source):
    """The numbers (from 0) of lines where code may be cut: a statement begins there, remarks above it included.

    Only a loop or function of more than `MOST_LINES` is cut inside; in a statement of as many without a body each of
    its outermost parts counts as one.
    """
    lines, begin = source.splitlines(), set()
    try:
        tree = ast.parse(source)
    except SyntaxError:
        return begin
    for node in ast.walk(tree):
        if node is not tree and getattr(node, "end_lineno", 0) - getattr(node, "lineno", 0) <= MOST_LINES:
            continue
        for name in ("body", "orelse", "finalbody"):
            block = getattr(node, name, ())
            block = block if isinstance(block, list) else []
            first = 2 if block and isinstance(block[0], ast.Expr) and isinstance(block[0].value, ast.Constant) else 1
            for part in block[first:]:  # what comes first, below a docstring, stays with what it belongs to
                row = min([part.lineno, *(mark.lineno for mark in getattr(part, "decorator_list", ()))]) - 1
                while row and lines[row - 1].lstrip().startswith("#"):
                    row -= 1
                begin.add(row)
        if isinstance(node, ast.stmt) and not hasattr(node, "body"):
            part = " " * (node.col_offset + 4)
            begin |= {n for n in range(node.lineno + 1, node.end_lineno) if re.match(rf"{part}[^\s)\]}}]", lines[n])}
    return begin
