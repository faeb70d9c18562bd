"""One executed chapter as the HTML of a slide deck.

A cell's heading or `slide_type` begins a slide. On it stand what `slide_content.py` leaves of the prose, code with what
it prints, figures and scenes; the rest of the prose is in the notes. What cannot be parted without harm, a sentence
with its code, or a picture, is one `.unit`; `deck.js` fills slides with units and makes each slide fit its pixels.
"""

import html
import itertools
import re
from dataclasses import dataclass, field

from book.chapters import cells, lint_code
from book.publish import markup

HIDDEN = ("remove-cell", "solution", "check")
FOR_THE_SPEAKER = re.compile(r"^\*For the speaker[.:]\*\s*")
EXERCISE = re.compile(r"### Exercise (\d+\.\d+) · (.+)")
EFFORT = re.compile(r"\*Difficulty (\d) of 5, about (\d+) minutes\b")

#: How long a class looks at things (s), beside the time to say the words: a line of code, a formula, a picture, ...
WORDS_A_SECOND = 2.2
SECONDS = {"line": 8, "formula": 15, "picture": 40, "predict": 90, "recall": 180, "play": 300}


@dataclass
class Unit:
    """What stays together on a slide: prose, then one cell of code; what the speaker says to it, and for how long."""

    pieces: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    seconds: float = 0.0
    has_code: bool = False

    def html(self):
        note = f'<div class="note" data-seconds="{self.seconds:.0f}">{"".join(self.notes)}</div>'
        return f'<div class="unit">{"".join(self.pieces)}{note}</div>'


@dataclass
class Slide:
    """A slide before it is fitted: its units, and the title of a section that has nothing else to show."""

    units: list[Unit] = field(default_factory=list)
    only_title: str = ""

    def unit(self):
        """The unit that prose is added to: a fresh one after code."""
        if not self.units or self.units[-1].has_code:
            self.units.append(Unit())
        return self.units[-1]


def stacks(notebook):
    """The deck as a list of stacks (one an H2), each a list of `Slide`s; cells of type `skip` are left out."""
    made = [[slide(cells_of_one) for cells_of_one in stack] for stack in grouped(notebook)]
    table = exercises(notebook)
    if table and made:
        made[-1][-1].unit().pieces.append(table)
        made[-1][-1].only_title = ""
    return [titled(stack) for stack in made]


def grouped(notebook):
    """The cells that are shown or said, by stack and by slide; an exercise ends what is shown of its section."""
    out, in_exercises = [], False
    for cell in itertools.chain.from_iterable(map(before_and_below, notebook["cells"])):
        kind = cells.slide_type(cell)
        in_exercises = "exercise" in cells.tags(cell) or (in_exercises and kind != "slide")
        if cells.is_note(cell) and out:
            out[-1][-1].append(cell)
            continue
        if in_exercises or kind == "skip" or any(tag in HIDDEN for tag in cells.tags(cell)) or imports(cell):
            continue
        if kind == "slide" or not out:
            out.append([[]])
        elif kind == "subslide":
            out[-1].append([])
        out[-1][-1].append(cell)
    return out


def imports(cell):
    return cells.is_code(cell) and lint_code.has_imports(cells.source(cell))


def before_and_below(cell):
    """A cell as it is; or cut where its heading stands below other text, which belongs to the slide before."""
    cut = LATE_HEADING.match(cells.source(cell)) if not cells.is_code(cell) else None
    if not cut or cells.headings(cell) == []:
        return [cell]
    above = {"cell_type": "markdown", "metadata": {}, "source": cut[1]}
    return [above, {**cell, "source": cells.source(cell)[cut.end() :]}]


LATE_HEADING = re.compile(r"(?!#)(.*?\n\n)(?=#{2,3} )", re.DOTALL)


def titled(stack):
    """The slides, each with a title: a heading alone goes above the next one, a slide without one has the last."""
    out, alone, last = [], "", ""
    for slide in filter(lambda slide: slide.units, stack):
        if slide.only_title:
            alone = last = slide.only_title
            continue
        first = slide.units[0].pieces
        heading = HEADING.search("".join(first[:1]))
        if heading and alone:
            first.insert(0, f'<div class="piece"><p class="title">{alone}</p></div>')
        elif not heading and last:
            first.insert(0, f'<div class="piece"><p class="again">{last}</p></div>')
        alone, last = "", heading[1] if heading else last
        out.append(slide)
    return out


HEADING = re.compile(r"<h[123]>(.*?)</h[123]>")


def slide(cells_of_one):
    """A slide of these cells."""
    made, alone = Slide(), not any(map(cells.is_code, cells_of_one))
    for cell in cells_of_one:
        kind = cells.slide_type(cell)
        if cells.is_note(cell):
            (made.units[-1] if made.units else made.unit()).notes.append(
                markup.prose(FOR_THE_SPEAKER.sub("", cells.source(cell)))
            )
        elif cells.is_code(cell):
            add_code(made, cell, kind)
        else:
            add_prose(made, cell, kind, alone)
    return made


def add_prose(made, cell, kind, alone):
    unit, tags = made.unit(), set(cells.tags(cell))
    shown, said = markup.screened(cells.source(cell), "predict" in tags, alone)
    if shown:
        unit.pieces.append(piece(shown, kind, "predict" if "predict" in tags else ""))
        heading = HEADING.fullmatch(shown)
        made.only_title = heading[1] if heading and len(made.units) == len(unit.pieces) == 1 else ""
    asked = [tag for tag in ("predict", "recall", "play") if tag in tags]
    unit.notes += [f'<p class="ask">{ASK[tag]}</p>' for tag in asked]
    if said:
        unit.notes.append(f'<div class="say">{said}</div>')
    unit.seconds += cells.word_count(cell) / WORDS_A_SECOND + sum(SECONDS[tag] for tag in asked)
    unit.seconds += SECONDS["formula"] * shown.count('class="formula"')


#: What the speaker does at a cell with this tag.
ASK = {
    "predict": "<b>Ask,</b> and wait for hands. The answer comes with the next key.",
    "recall": "<b>Ask</b> the three questions one by one; the answers:",
    "play": "<b>Let the class say</b> where the sliders should go, and what will happen, before you move them.",
}


def add_code(made, cell, kind):
    pieces = list(markup.rendered(cell))
    if not pieces:
        return
    picture = markup.shows_picture(cell)
    unit = made.unit()
    unit.pieces.append(piece("".join(pieces), kind, cell=cell.get("id", "")))
    unit.has_code, made.only_title = True, ""
    lines = cell["metadata"].get("lines", len(cells.code_lines(cell)))
    unit.seconds += SECONDS["picture"] if picture else SECONDS["line"] * lines


def piece(text, kind, name="", cell=""):
    words = " ".join(word for word in ("piece", name, "fragment" if kind == "fragment" else "") if word)
    where = f' data-cell="{cell}"' if cell else ""
    return f'<div class="{words}"{where}>{text}</div>'


def exercises(notebook):
    """A table of the chapter's exercises: name, difficulty, minutes; '' where there is none."""
    texts = [cells.source(cell) for cell in notebook["cells"] if "exercise" in cells.tags(cell)]
    rows = "".join(map(exercise, texts))
    return f'<div class="piece"><table class="exercises"><tbody>{rows}</tbody></table></div>' if rows else ""


def exercise(text):
    """One row of that table."""
    name, effort = EXERCISE.match(text), EFFORT.search(text)
    number, words = name.groups() if name else ("", text.splitlines()[0].lstrip("# "))
    level, time = (int(effort[1]), f"{effort[2]} min") if effort else (0, "")
    dots = f'<span aria-label="difficulty {level} of 5">{"●" * level}{"○" * (5 - level)}</span>' if level else ""
    return f"<tr><td>{number}</td><td>{html.escape(words)}</td><td>{dots}</td><td>{time}</td></tr>"


def minutes(notebook):
    """How long a class needs for the deck, in minutes."""
    return sum(unit.seconds for stack in stacks(notebook) for slide in stack for unit in slide.units) / 60


def sections(notebook):
    """The deck's <section> elements."""
    inner = ["\n".join(section(slide) for slide in stack) for stack in stacks(notebook) if stack]
    return "\n".join(f"<section>\n{text}\n</section>" for text in inner)


def section(slide):
    return f"<section>{''.join(unit.html() for unit in slide.units)}</section>"
