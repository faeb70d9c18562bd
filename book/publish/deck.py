"""One executed chapter as the HTML of a slide deck.

A cell's heading or `slide_type` begins a slide. On it stand what `screen.py` leaves of the prose, code with what it
prints, figures and scenes; the rest of the prose is in the notes. What cannot be parted without harm, a sentence with
its code, or a picture, is one `.unit`; `deck.js` fills slides with units and makes each slide fit its pixels.
"""

import html
import re
from dataclasses import dataclass, field

from book.chapters import cells
from book.publish import markup

HIDDEN = ("remove-cell", "solution", "check")
EXERCISE = re.compile(r"### Exercise (\d+\.\d+) · (.+)")
EFFORT = re.compile(r"\*Difficulty (\d) of 5, about (\d+) minutes")

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
    out, in_exercises = [], False
    for cell in notebook["cells"]:
        kind = cells.slide_type(cell)
        if "exercise" in cells.tags(cell):
            in_exercises = True
        elif kind == "slide":
            in_exercises = False
        if in_exercises or kind == "skip" or any(tag in HIDDEN for tag in cells.tags(cell)):
            continue
        if kind == "slide" or not out:
            out.append([Slide()])
        elif kind == "subslide":
            out[-1].append(Slide())
        add(out[-1][-1], cell, kind)
    table = exercises(notebook)
    if table and out:
        out[-1][-1].unit().pieces.append(table)
    return [titled([slide for slide in stack if slide.units]) for stack in out]


def titled(stack):
    """A slide with a heading only is the title above the next slide's."""
    for slide, following in zip(stack, stack[1:], strict=False):
        if slide.only_title and len(slide.units) == 1:
            following.units[0].pieces.insert(0, f'<p class="title">{slide.only_title}</p>')
            slide.units = []
    return [slide for slide in stack if slide.units]


def add(slide, cell, kind):
    """Put a cell on a slide: its pieces, what is said to it, and how long that takes."""
    if kind == "notes":
        (slide.units[-1] if slide.units else slide.unit()).notes.append(markup.prose(cells.source(cell)))
    elif cells.is_code(cell):
        add_code(slide, cell, kind)
    else:
        add_prose(slide, cell, kind)


def add_prose(slide, cell, kind):
    unit, tags = slide.unit(), set(cells.tags(cell))
    shown, said, title = markup.screened(cells.source(cell), whole="predict" in tags)
    if shown:
        unit.pieces.append(piece(shown, kind, "predict" if "predict" in tags else ""))
        slide.only_title = title if len(slide.units) == len(unit.pieces) == 1 else ""
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


def add_code(slide, cell, kind):
    pieces = list(markup.rendered(cell))
    if not pieces:
        return
    picture = markup.shows_picture(cell)
    unit = slide.unit()
    unit.pieces.append(piece("".join(pieces), kind))
    unit.has_code, slide.only_title = True, ""
    unit.seconds += SECONDS["picture"] if picture else SECONDS["line"] * len(cells.code_lines(cell))


def piece(text, kind, name=""):
    words = " ".join(word for word in ("piece", name, "fragment" if kind == "fragment" else "") if word)
    return f'<div class="{words}">{text}</div>'


def exercises(notebook):
    """A table of the chapter's exercises: name, difficulty, minutes; '' where there is none."""
    rows, minutes = [], 0
    for cell in notebook["cells"]:
        if "exercise" in cells.tags(cell):
            number, name = EXERCISE.match(cells.source(cell)).groups() if EXERCISE.match(cells.source(cell)) else ("", "")
            effort = EFFORT.search(cells.source(cell))
            level, time = map(int, effort.groups()) if effort else (0, 0)
            minutes += time
            dots = f'<span aria-label="difficulty {level} of 5">{"●" * level}{"○" * (5 - level)}</span>' if level else ""
            rows.append(f"<tr><td>{number}</td><td>{html.escape(name)}</td><td>{dots}</td><td>{time or ''} min</td></tr>")
    return f'<div class="piece"><table class="exercises"><tbody>{"".join(rows)}</tbody></table></div>' if rows else ""


def minutes(notebook):
    """How long a class needs for the deck, in minutes."""
    return sum(unit.seconds for stack in stacks(notebook) for slide in stack for unit in slide.units) / 60


def sections(notebook):
    """The deck's <section> elements."""
    inner = ["\n".join(section(slide) for slide in stack) for stack in stacks(notebook) if stack]
    return "\n".join(f"<section>\n{text}\n</section>" for text in inner)


def section(slide):
    return f"<section>{''.join(unit.html() for unit in slide.units)}</section>"
