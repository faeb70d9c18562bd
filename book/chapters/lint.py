"""The conventions of a chapter that a machine can check: `python -m book.chapters.lint [notebooks...]`.

A rule takes the cells of a chapter and yields (cell number from 1, what is wrong); 0 means the whole chapter.
"""

import itertools
import re
import sys
from pathlib import Path

from book.chapters import lint_code, lint_numbers, normalise
from book.chapters.cells import (
    SLIDE_TYPES,
    TAGS,
    code_lines,
    default_slide_type,
    headings,
    is_code,
    is_note,
    prose,
    slide_type,
    source,
    tags,
    word_count,
)
from book.setup.names import FILE_NAME
from book.setup.paths import in_a_sentence

WORDS_PER_LINE = 8
LINES_PER_CELL = 15
MAX_BYTES = 400_000
OBJECTIVES = "you will be able to"
IMAGE = re.compile(r"!\[([^\]]*)\]\(([^)\s]+)[^)]*\)")
LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)#\s]+)[^)]*\)")
UNSTABLE = re.compile(r"\b(at )?0x[0-9a-f]{6,}|\x1b\[|(?<![\w.])/(home|root|tmp|usr|work|Users)/")


def one_title(cells):
    titles = [number for number, cell in enumerate(cells, 1) for level, _ in headings(cell) if level == 1]
    if titles != [1]:
        yield 0, f"wants one H1, in its first cell; it has them in cells {titles}"


def one_hook(cells):
    paragraphs = [p for p in re.split(r"\n\s*\n", prose(cells[0]) + "\n\n" + prose(cells[1])) if p.strip()]
    hook = next((p for p in paragraphs if not p.lstrip().startswith("#")), "")
    sentences = re.findall(r"[.!?:](?=[\s*_)”\"]*(\s[A-Z]|$))", hook.strip())
    if not hook or OBJECTIVES in hook.lower() or len(sentences) != 1:
        yield 1, "wants a hook of one sentence between the title and the objectives"


def three_objectives(cells):
    for number, cell in enumerate(cells, 1):
        if found := re.search(OBJECTIVES, prose(cell), re.I):
            after = prose(cell)[found.end() :].split("\n#")[0]
            items = re.findall(r"^\s*(?:[-*]|\d+\.)\s+\S", after, re.M)
            if len(items) != 3:
                yield number, f"'You will be able to' wants three items, it has {len(items)}"
            return
    yield 0, "has no 'You will be able to'"


def closing_sections(cells):
    titles = [title.lower() for cell in cells for level, title in headings(cell) if level == 2]
    for wanted in ("summary", "exercises"):
        if not any(title.startswith(wanted) for title in titles):
            yield 0, f"has no section '## {wanted.capitalize()}'"


def imports_in_one_cell(cells):
    importing = [
        number for number, cell in enumerate(cells, 1) if is_code(cell) and lint_code.has_imports(source(cell))
    ]
    for number in importing[1:]:
        yield number, f"imports; all imports belong in cell {importing[0]}"


def known_tags(cells):
    for number, cell in enumerate(cells, 1):
        for tag in tags(cell):
            if tag not in TAGS:
                yield number, f"has the unknown tag {tag!r}; known are {', '.join(sorted(TAGS))}"


def slides(cells):
    for number, cell in enumerate(cells, 1):
        kind = slide_type(cell)
        if kind not in SLIDE_TYPES:
            yield number, f"has slide type {kind!r}; it must be one of {', '.join(SLIDE_TYPES)}"
        for level, title in headings(cell):
            if level in (2, 3) and kind != default_slide_type(cell):
                yield number, f"begins {title!r} (H{level}): its slide type follows from that; remove {kind!r}"


def wrong_answers_are_expected(cells):
    """Below a Predict the speaker reads which wrong answer to expect, before the cell that shows the right one."""
    for number, cell in enumerate(cells, 1):
        if "predict" in tags(cell):
            notes = itertools.takewhile(lambda below: is_code(below) or is_note(below), cells[number:])
            if not any(is_note(note) and "**Expect**" in source(note) for note in notes):
                yield (
                    number,
                    "is a Predict without a note for the speaker below it: '*For the speaker.* **Expect** ...'",
                )


def prose_first(cells):
    words, lines = sum(map(word_count, cells)), sum(len(code_lines(cell)) for cell in cells)
    if words < WORDS_PER_LINE * lines:
        yield 0, f"has {words} words for {lines} lines of code, {words / lines:.1f} a line; {WORDS_PER_LINE} are wanted"


def short_cells(cells):
    for number, cell in enumerate(cells, 1):
        if len(code_lines(cell)) > LINES_PER_CELL:
            yield number, f"has {len(code_lines(cell))} lines of code; {LINES_PER_CELL} at most"


def plain_code(cells):
    for number, cell in enumerate(cells, 1):
        if is_code(cell):
            for problem in lint_code.problems(source(cell)):
                yield number, problem
            if "solution" not in tags(cell) and re.search(r"\bTODO\b", source(cell)):
                yield number, "says TODO"


def exercises(cells):
    """An exercise, then its solution cells, then its check cells; an answer in words alone needs no check."""
    state = "check"
    for number, cell in enumerate(cells, 1):
        for tag in ("exercise", "solution", "check"):
            if tag in tags(cell):
                if state not in MAY_FOLLOW[tag]:
                    yield number, f"is tagged {tag!r} after {state!r}; the order is exercise, solution, check"
                if tag == "exercise" and "hint" not in source(cell).lower():
                    yield number, "is an exercise without a hint"
                if tag == "exercise" and not re.match(r"### Exercise \d+\.\d+\b", source(cell)):
                    yield number, "is an exercise that does not begin with its heading, `### Exercise 7.1 · Its name`"
                in_words = tag == "solution" and not is_code(cell) and state != "solution"
                state = "written" if in_words else tag
    if state not in ("check", "written"):
        yield 0, f"ends with {state!r}; the order is exercise, solution, check"


#: Which of the last tagged cells a cell with this tag may follow; `written` is a solution in words.
MAY_FOLLOW = {
    "exercise": ("check", "written"),
    "solution": ("exercise", "solution", "written"),
    "check": ("solution", "written", "check"),
}
DIFFICULTY = re.compile(r"^\*Difficulty [1-5] of 5, about \d+ minutes\.\*$", re.M)


def the_student_works(cells):
    """Recall at the start; six exercises with their difficulty, two symbolic, one broken program, one in words."""
    recalls = [cell for cell in cells if "recall" in tags(cell)]
    if len(recalls) != 1 or source(recalls[0]).count("<summary>Answer</summary>") != 3:
        yield 0, "wants one cell tagged 'recall' with three questions, each with its answer in a <details>"
    asked = [number for number, cell in enumerate(cells, 1) if "exercise" in tags(cell)]
    if len(asked) < 6:
        yield 0, f"has {len(asked)} exercises; 6 are wanted"
    for number in asked:
        if not DIFFICULTY.search(source(cells[number - 1])):
            yield number, "is an exercise without a line `*Difficulty 2 of 5, about 10 minutes.*`"
    symbolic = [cell for cell in cells if "check" in tags(cell) and SYMBOLIC.search(source(cell))]
    if len(symbolic) < 2:
        yield 0, f"has {len(symbolic)} exercises judged by check.expression or prove_equal; 2 are wanted"
    if not any("broken" in tags(cell) for cell in cells):
        yield 0, "has no program that is broken on purpose: a code cell tagged 'broken' below its exercise"
    written = [cell for cell in cells if "solution" in tags(cell) and not is_code(cell)]
    if not any("**Model answer.**" in source(cell) and "**Rubric.**" in source(cell) for cell in written):
        yield 0, "has no exercise in words: a Markdown solution with a **Model answer.** and a **Rubric.**"


HOURS = {"an": 60, "two": 120, "three": 180, "four": 240}
MINUTES = {
    "five": 5, "ten": 10, "a quarter": 15, "twenty": 20, "a half": 30, "forty": 40, "three quarters": 45, "fifty": 50,
}  # fmt: skip
TOGETHER = re.compile(f"Together they take about ({'|'.join(HOURS)}) hours?(?: and ({'|'.join(MINUTES)})\\b)?")


def the_minutes_add_up(cells):
    """What the exercises are said to take together is the sum of their minutes, to a tenth."""
    total = sum(
        int(minutes) for cell in cells for minutes in re.findall(r"^\*Difficulty .* (\d+) min", prose(cell), re.M)
    )
    for number, cell in enumerate(cells, 1):
        found = TOGETHER.search(prose(cell))
        if found and abs(HOURS[found[1]] + MINUTES.get(found[2], 0) - total) > total / 10:
            yield number, f"says {found[0]!r}, and the exercises add up to {total} minutes"


SYMBOLIC = re.compile(r"\bcheck\.expression\(|\bprove_equal\(")


def numbers_are_backed(cells):
    yield from lint_numbers.problems(cells)


def used_tags(cells):
    used = {tag for cell in cells for tag in tags(cell)}
    for tag, what in (("predict", "a question before a surprising cell"), ("play", "one widget or scene")):
        if tag not in used:
            yield 0, f"has no cell tagged {tag!r}: {what}"


def pictures_and_links(cells, folder):
    for number, cell in enumerate(cells, 1):
        for alt, target in IMAGE.findall(prose(cell)):
            if len(alt.split()) < 3:
                yield number, f"shows {target} without alt text that says what is seen"
        if re.search(r"<img(?![^>]*\balt=)", prose(cell)):
            yield number, "has an <img> without alt text"
        for target in [target for _, target in IMAGE.findall(prose(cell))] + LINK.findall(prose(cell)):
            if not re.match(r"[a-z]+:", target) and not (folder / target).exists():
                yield number, f"points to {target}, which does not exist"
        if cell.get("attachments"):
            yield number, "carries an attachment; put pictures into book/static"


def stored_outputs(cells):
    """Text outputs are stored, with counts; without them a comparing test would pass without a look."""
    if not any(cell.get("outputs") for cell in cells if is_code(cell)):
        yield 0, "has no stored output at all; run python run.py execute"
    for number, cell in enumerate(cells, 1):
        for output in cell.get("outputs", []):
            if output.get("name") == "stderr":
                yield number, "stores a warning (stderr)"
            if output["output_type"] == "error" and "raises-exception" not in tags(cell):
                yield number, "stores an error without the tag 'raises-exception'"
            if UNSTABLE.search("".join(map(str, output.get("data", output).values()))):
                yield number, "stores an output with an address, a colour code or an absolute path"


def filled(cells):
    """What `python run.py new-chapter` leaves to the author stands in «...»."""
    for number, cell in enumerate(cells, 1):
        for words in re.findall(r"«[^»]*»", source(cell)):
            yield number, f"still says {words}: write it"


RULES = (
    filled,
    one_title,
    one_hook,
    three_objectives,
    closing_sections,
    imports_in_one_cell,
    known_tags,
    slides,
    prose_first,
    short_cells,
    plain_code,
    exercises,
    used_tags,
    stored_outputs,
    the_student_works,
    the_minutes_add_up,
    numbers_are_backed,
    wrong_answers_are_expected,
)
START = "00"  # the first chapter shows around; it has no chapters before it and no derivation
NOT_FOR_START = (closing_sections, used_tags, the_student_works)


def problems(path):
    """Every problem of one chapter, as lines `name, cell n: what is wrong`."""
    path = Path(path)
    notebook = normalise.read(path)
    cells, found = notebook["cells"], []
    if not FILE_NAME.fullmatch(path.name):
        found.append((0, "is not called NN-topic.ipynb"))
    if path.stat().st_size > MAX_BYTES:
        found.append((0, f"is larger than {MAX_BYTES} bytes; are there pictures in it?"))
    if normalise.dumps(normalise.normalise(notebook)) != path.read_text(encoding="utf-8"):
        found.append((0, "is not in stored form; run python -m book.chapters.normalise"))
    for rule in RULES:
        if not (path.name.startswith(START) and rule in NOT_FOR_START):
            found += rule(cells)
    found += pictures_and_links(cells, path.parent)
    return [f"{path.name}{f', cell {number}' if number else ''}: {what}" for number, what in found]


def chapters(argv):
    """The chapters that are named; all notebooks, oddly named ones too, when none is."""
    return normalise.chapters(argv) if argv else sorted(normalise.NOTEBOOKS.glob("*.ipynb"))


@in_a_sentence
def main(argv=None):
    found = [problem for path in chapters(argv) for problem in problems(path)]
    print("\n".join(found) or "The chapters keep the conventions.")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
