"""What a student handed in: which file it is, and which of its cells are those of the chapter."""

import json

from book.chapters.cells import text_of
from book.chapters.student import grade_id

#: What a file raises that is no notebook, or a damaged one.
DAMAGED = (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError)


def found(place, key, name):
    """(the notebook of this chapter among what a student handed in, or None; what is to be said about it)."""
    if place is None:
        return None, "nothing handed in"
    files = [place] if place.is_file() else [path for path in sorted(place.rglob("*")) if path.is_file()]
    paths = [path for path in files if path.suffix.lower() == ".ipynb" and ".ipynb_checkpoints" not in path.parts]
    fits = sorted((held, path.stat().st_mtime, path) for path in paths if (held := held_in(path, key)))
    best = [path for _, _, path in fits]
    if not best:
        broken = [path for path in paths if path.stem.startswith(name[:2])]
        others = [path.name for path in files if passed_over(path, name)]
        but = f" but {', '.join(others)}: this chapter's notebook is wanted" if others else ""
        return (broken[0], "") if broken else (None, f"nothing handed in{but}")
    said = [] if best[-1].name == f"{name}.ipynb" else [f"graded: {best[-1].name}"]
    said += [f"{len(best)} notebooks of this chapter; the fullest and newest counts"] if len(best) > 1 else []
    return best[-1], "; ".join(said)


def passed_over(path, name):
    """Is this a file that may pass for the chapter: an archive, a page, a text, another notebook?"""
    return path.suffix.lower() in (".zip", ".ipynb") or path.name.startswith(name[:2])


def held_in(path, key):
    """(answers that are no TODO any more, graded cells of the chapter) in a notebook; None if it holds none."""
    todos = {cell["id"]: cell["source"] for cell in key["chapter"] if cell["role"] == "solution"}
    try:
        cells, _ = whole_cells(read(path)[0])
    except DAMAGED:
        return None
    held = {place: text_of(cell["source"]) for place, cell in zip(places(cells, key), cells, strict=True)}
    graded = held.keys() & set(key["graded"].values())
    answered = sum(held.get(place, todo).strip() != todo.strip() for place, todo in todos.items())
    return (answered, len(graded)) if graded else None


def read(path):
    """(the notebook's JSON, notes): in UTF-8, 16 or 32, with or without a byte order mark, or else in Latin letters."""
    content = path.read_bytes()
    try:
        return json.loads(content), []
    except UnicodeDecodeError:
        return json.loads(content.decode("latin-1")), ["its letters are not stored as UTF-8: some may be wrong"]


def whole_cells(notebook):
    """(the cells that can be read, notes on those that cannot)."""
    cells, notes = [], []
    for number, cell in enumerate(notebook["cells"], 1):
        try:
            hash((cell["cell_type"], text_of(cell["source"]), grade_id(cell), cell.get("id")))
            cells.append(cell)
        except DAMAGED:
            notes.append(f"cell {number} is damaged and was left out")
    return cells, notes


def places(cells, key):
    """Which cell of the chapter each cell is, None for the student's own.

    It is known by the grader's mark, or by its id. Without these a check and a given cell are known by their text, if
    most checks are there, and an answer by the check behind it.
    """
    graded = set(key["graded"].values())
    ids = graded | {cell["id"] for cell in key["chapter"]}
    known = [key["graded"].get(grade_id(cell)) or (cell.get("id") if cell.get("id") in ids else None) for cell in cells]
    by_text = {}
    for cell in key["chapter"]:
        if cell["id"] not in known and cell["role"] != "solution":
            for text in {cell["source"].strip(), cell["thin"].strip()}:
                by_text.setdefault(text, []).append(cell["id"])
    alike = [by_text.get(text_of(cell["source"]).strip(), []) for cell in cells]
    answers = {exercise["check"]: exercise["cells"] for exercise in key["exercises"]}
    if 2 * len(answers.keys() & {*known, *(place for texts in alike for place in texts)}) < len(answers):
        return known
    for number, texts in enumerate(alike):
        if known[number] is None and texts:
            known[number] = texts.pop(0) if len(texts) > 1 else texts[0]
    for number, place in enumerate(known):
        wanted, before = [answer for answer in answers.get(place, ()) if answer not in known], number - 1
        while wanted and before >= 0 and known[before] not in graded:
            if known[before] is None and cells[before]["cell_type"] == "code":
                known[before] = wanted.pop()
            before -= 1
    return known


def submission(path, key):
    """([{"id", "source"}, ...] of what is run, what was mended) of a student's notebook."""
    notebook, notes = read(path)
    whole, damaged = whole_cells(notebook)
    own, cells, twice = {cell["id"]: cell for cell in key["chapter"]}, [], {}
    for number, (cell, place) in enumerate(zip(whole, places(whole, key), strict=True)):
        is_code, is_graded = cell["cell_type"] == "code", place in own and own[place]["role"] != "given"
        if not (is_code or is_graded):
            continue
        if is_graded:
            twice[place] = twice.get(place, 0) + 1
            notes += [] if is_code else [f"{label(place, key)}: was turned to {cell['cell_type']}"]
        cells.append({"id": place or f"extra-{number}", "source": text_of(cell["source"])})
    notes += [
        *damaged,
        *(f"{label(p, key)}: is there {n} times; the last one counts" for p, n in twice.items() if n > 1),
    ]
    marked = [place for exercise in key["exercises"] for place in (*exercise["cells"], exercise["check"])]
    notes += [f"{label(place, key)}: was deleted" for place in dict.fromkeys(marked) if place not in twice]
    stand = [cell["id"] for cell in cells]
    if [p for p in stand if p in own and stand.count(p) == 1] != [p for p in own if stand.count(p) == 1]:
        notes.append("its cells stand in another order than in the sheet; they were run as they stand")
    return checks_behind_answers(cells, key), notes


def label(place, key):
    return next(name for name, cell in key["graded"].items() if cell == place)


def checks_behind_answers(cells, key):
    """The cells with each check once, behind the last copy of it and of its answers: there the answers are taken."""
    checks = {exercise["check"]: {exercise["check"], *exercise["cells"]} for exercise in key["exercises"]}
    rest = [(number, cell) for number, cell in enumerate(cells) if cell["id"] not in checks]
    for check, about in checks.items():
        if at := [number for number, cell in enumerate(cells) if cell["id"] in about]:
            rest.append((at[-1], {"id": check, "source": ""}))
    return [cell for _, cell in sorted(rest, key=lambda one: one[0])]
