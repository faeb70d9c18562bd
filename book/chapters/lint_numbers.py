"""A number in prose is a claim: some cell of its chapter prints it, holds it or asserts it.

    python -m book.chapters.lint_numbers [notebooks...]

Free are formulas and code, years, names with digits in them (chapter 3, joints 2 to 4, 4x4, XM430), quarter turns, and
small counts without a unit. A number that the world gives (a data sheet, a source) stands in the cell's comment
`<!-- given: 380, 0.2, the maker's manual -->`, which no page shows.
"""

import re
import sys

from book.chapters import normalise
from book.chapters.cells import MATHS, is_code, prose, source, text_of

NAMES = (
    "chapters?|exercises?|joints?|frames?|rows?|columns?|steps?|links?|sections?|tables?|figures?|cells?|labs?|"
    "sources?|ids?|servos?|meetings?|axes|axis|numbers?|waypoints?|cases?|bits?|bytes?|registers?|protocol|python"
)
LABEL = re.compile(rf"\b(?:{NAMES})\s+\d+(?:\.\d+)*(?:(?:,| and| to| or|,? and|–|-)\s*\d+(?:\.\d+)*)*\b", re.I)
NOT_PROSE = (
    re.compile(r"<!--.*?-->", re.S),
    re.compile(r"`[^`]*`"),
    MATHS,
    re.compile(r"\]\([^)]*\)"),  # targets of links
    re.compile(r"</?\w[^>]*>"),
    re.compile(r"^#+ \d+ · ", re.M),
    re.compile(r"^\*Difficulty .*\*$", re.M),
    re.compile(r"^\s*\d+\.\s", re.M),  # numbered items
)
GIVEN = re.compile(r"<!--\s*given:(.*?)-->", re.S)
SHAPE = re.compile(r"\b\d+\s?[×x]\s?\d+\b|\b\d-D\b")
DIGITS = re.compile(r"(?<![\w.])\d+(?:[ \u00a0\u202f]\d{3}(?!\d))*(?:\.\d+)?(?:e-?\d+)?(?![\w]|-[A-Za-z])")
UNIT = re.compile(r"\s?(?:mm|cm|m|°|deg|rad|%|per cent|N|kg|g|s|ms|us|µs|V|A|mA|Hz|kHz|rpm|W|J)(?![\w])")
SMALL = 12
#: What a known number may be multiplied with to become one with this unit: a share, or 1000 of one are 1 of another.
SCALES = {"%": (1.0, 100.0), "per cent": (1.0, 100.0)} | dict.fromkeys(("g", "mm", "ms", "mA", "m"), (1.0, 1e3, 1e-3))
QUARTERS = {90.0, 180.0, 270.0, 360.0}


def problems(cells):
    """(cell number from 1, what is wrong) for each number in prose that nothing in the chapter backs."""
    known = {value for cell in cells if is_code(cell) for value in values(backing(cell))}
    for number, cell in enumerate(cells, 1):
        given = {value for text in GIVEN.findall(source(cell)) for value in values(text)}
        for text, unit in claims(prose(cell)):
            if not backed(text, unit, known | given):
                yield number, f"says {text}{unit}, which no cell of the chapter prints, holds or asserts"


def claims(text):
    """The numbers of a piece of prose as (digits, unit), those that need no backing left out."""
    for pattern in NOT_PROSE:
        text = pattern.sub(" ", text)
    text = SHAPE.sub(" ", LABEL.sub(" ", " ".join(text.split())))
    for found in DIGITS.finditer(text):
        unit = UNIT.match(text, found.end())
        digits, unit = found[0], unit[0].strip() if unit else ""
        value = number_of(digits)
        free = value <= SMALL if not unit else unit in ("°", "deg") and value in QUARTERS
        year = not unit and re.fullmatch(r"(19|20)\d\d", digits)
        if year or (free and value == int(value)):
            continue
        yield digits, unit


def backing(cell):
    """The text of a code cell and of what it prints."""
    printed = [text_of(output.get("text", "")) for output in cell.get("outputs", [])]
    data = [text_of(value) for o in cell.get("outputs", []) for value in o.get("data", {}).values() if value]
    return "\n".join([source(cell), *printed, *data])


def values(text):
    """The sizes of the numbers in code or in an output, without their signs."""
    return {float(digits.replace("_", "")) for digits in re.findall(r"(?<![\w.#])\d[\d_]*(?:\.\d+)?(?:e-?\d+)?", text)}


def backed(digits, unit, known):
    """Is the number one of the known ones, rounded to the digits that the prose gives, perhaps in another unit?"""
    value, decimals = number_of(digits), len(digits.partition(".")[2])
    scales = SCALES.get(unit, (1.0,))
    half = 0.5 * 10.0**-decimals + 1e-9
    return any(abs(known_value * scale - value) <= half for known_value in known for scale in scales)


def number_of(digits):
    return float(re.sub(r"[ \u00a0\u202f]", "", digits))


def main(argv=None):
    found = [
        f"{path.name}, cell {number}: {what}"
        for path in normalise.chapters(argv or [])
        for number, what in problems(normalise.read(path)["cells"])
    ]
    print("\n".join(found) or "Every number in prose is backed by a cell.")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
