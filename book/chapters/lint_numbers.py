"""A number in prose is a claim: some cell of its chapter prints it, holds it or asserts it.

    python -m book.chapters.lint_numbers [notebooks and pages...]

Free are formulas and code, years, names with digits in them (chapter 3, joints 2 to 4, 4x4, XM430), quarter turns, and
small counts without a unit. A number that the world gives (a data sheet, a source) stands in the cell's comment
`<!-- given: 380, 0.2, the maker's manual -->`, which no page shows.

Words are numbers, too: *a third of the cells*, *four times as fast*, *half a millimetre*. The comment
`<!-- so: 1 - 1976/2912, 268/60 -->` of the cell computes them from numbers that the chapter prints, or they are given.
Questions, quoted words and the tolerances of estimates claim nothing.

A page names the files whose numbers it tells, behind its title for all of it or in a section:
`<!-- backed by: notebooks/10-*, tests/book/test_sources.py -->`.
"""

import functools
import math
import re
import sys

from book.chapters import normalise
from book.chapters.cells import FENCED, MATHS, is_code, prose, source, text_of
from book.setup.paths import ROOT, in_a_sentence

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
SO = re.compile(r"<!--\s*so:(.*?)-->", re.S)
BACKED_BY = re.compile(r"<!--\s*backed by:(.*?)-->", re.S)
SHAPE = re.compile(r"\b\d+\s?[×x]\s?\d+\b|\b\d-D\b")
DIGITS = re.compile(r"(?<![\w.])\d+(?:[ \u00a0\u202f]\d{3}(?!\d))*(?:\.\d+)?(?:e-?\d+)?(?![\w]|-[A-Za-z])")
UNIT = re.compile(
    r"\s?(?:mm|cm|m|°|deg|rad|%|per cent|N|kg|g|s|ms|us|µs|V|A|mA|Hz|kHz|rpm|W|J)(?![\w])"
    r"|[ -](?:milli|centi|kilo)?(?:met|lit)res?\b|[ -](?:degree|percent|pixel|second|gram|tick|time)s?\b"
)
SMALL = 12
#: What a known number may be multiplied with to become one with this unit: a share, or 1000 of one are 1 of another.
SCALES = {"%": (100.0,), "per cent": (100.0,), "percent": (100.0,)} | dict.fromkeys(
    ("g", "mm", "ms", "mA", "m"), (1.0, 1e3, 1e-3)
)
QUARTERS = {90.0, 180.0, 270.0, 360.0}


SMALL_ONES = ("two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
ROUND_ONES = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety", "a hundred")
COUNTS = dict(zip(SMALL_ONES, range(2, 13), strict=True)) | dict(zip(ROUND_ONES, range(20, 101, 10), strict=True))
COUNTS |= {"fifteen": 15, "two hundred": 200, "a thousand": 1e3, "two thousand": 2e3, "a million": 1e6}
PARTS = {"half": 2, "third": 3, "quarter": 4, "fifth": 5, "sixth": 6, "eighth": 8, "tenth": 10, "twentieth": 20}
PARTS |= {"hundredth": 100, "thousandth": 1e3, "ten-thousandth": 1e4, "millionth": 1e6, "billionth": 1e9}
MULTIPLES = {"twice": 2, "doubles": 2, "trebles": 3, "tenfold": 10}
COUNT, PART = ("|".join(sorted(words, key=len, reverse=True)) for words in (COUNTS, PARTS))
MEASURED = r"(?:milli|centi|kilo)?(?:met|lit)res?|degrees?|per ?cent|(?:kilo)?grams?|amperes?"
THAN = r"(?:as|what|too|more|less|its|his|far|long|fast|slow|larg|small|near|furth|bett|fin)"
NO_HALF = "".join(f"(?<!{word} )" for word in ("the", "right", "one", "upper", "front", "from", "which", "to"))
#: A number in words: a part of a unit, an amount with its unit, a multiple, a share.
WORDS = re.compile(
    rf"\b(?P<bound>(?:more|less) than |over |under |almost |nearly |up to )?(?:"
    rf"(?P<part>(?:(?:{COUNT}|a|one) )?(?:{PART})s?) (?:of )?(?:an? )?(?:{MEASURED}|pixel)\b"
    rf"|(?P<count>(?:(?:{COUNT}) (?:to|or) )?(?:{COUNT}))[ -](?:{MEASURED})\b"
    rf"|(?P<times>twice|(?:(?:{COUNT}) to )?(?:{COUNT}) times)(?= {THAN})"
    rf"|(?<!neighbouring )(?<!in )(?P<verb>doubles|trebles|tenfold)\b"
    rf"|(?P<share>(?:{COUNT}|a) (?:{PART})s?|{NO_HALF}half)(?= of (?!a |the last)| as (?:much|many)| small| larg| slow)"
    rf"|(?<=than )(?P<than>(?:{COUNT}|a) (?:{PART})s?|half)(?=[.,;]))",
    re.I,
)
KINDS = ("part", "count", "times", "verb", "share", "than")
NO_CLAIM = (
    re.compile(r"[\"“][^\"”]*[\"”]"),  # what somebody says
    re.compile(r"[^.?!:]*\?"),
    re.compile(rf"\b(?:to|within) (?:a|an|two) (?:{PART})s?\b", re.I),  # how good an estimate must be
)


def problems(cells):
    """(cell number from 1, what is wrong) for each number in prose that nothing in the chapter backs."""
    known = {value for cell in cells if is_code(cell) for value in held(cell)}
    for number, cell in enumerate(cells, 1):
        yield from ((number, what) for what in unbacked(source(cell), prose(cell), known, "no cell of the chapter"))


def page_problems(text, folder=ROOT):
    """(line number, what is wrong) for each number of a page that none of the files backs which it names."""
    line, *sections = 1, *re.split(r"^(?=## )", text, flags=re.M)
    for section in sections:
        comments = section if line == 1 else sections[0] + section
        names = [name.strip() for names in BACKED_BY.findall(comments) for name in names.split(",")]
        known = {value for name in names for path in folder.glob(name) for value in numbers_in(path)}
        plain = FENCED.sub(lambda fence: "\n" * fence[0].count("\n"), section)
        for number, row in enumerate(plain.splitlines(), line):
            yield from ((number, what) for what in unbacked(comments, row, known, "none of its files"))
        line += section.count("\n")


@functools.cache
def numbers_in(path):
    """The numbers that a chapter's code and outputs hold, or a file of Python."""
    if path.suffix == ".ipynb":
        return {value for cell in normalise.read(path)["cells"] if is_code(cell) for value in held(cell)}
    return held({"source": path.read_text(encoding="utf-8")})


def held(cell):
    """The numbers of a code cell and of what it prints. An index or a count in code, up to 12, is no amount."""
    printed = [text_of(output.get("text", "")) for output in cell.get("outputs", [])]
    printed += [text_of(value) for o in cell.get("outputs", []) for value in o.get("data", {}).values() if value]
    amounts = "\n".join([*printed, *(line for line in source(cell).splitlines() if AMOUNT.search(line))])
    return values(amounts) | {value for value in values(source(cell)) if value > SMALL or value != int(value)}


AMOUNT = re.compile(r"assert|_(?:mm|deg|s|g|kg|px)\b|\b(?:mm|deg)\b")


def unbacked(whole, text, known, nobody):
    """What is wrong with the numbers of `text`; the comments that back them stand in `whole`."""
    given = {value for found in GIVEN.findall(whole) for value in values(found)}
    derived = set(given)
    for expression in (one for found in SO.findall(whole) for one in found.split(",")):
        for digits in re.findall(r"\d+(?:\.\d+)?", expression):
            if not (free_count(digits) or re.fullmatch("100*", digits) or backed(digits, "", known | given)):
                yield f"computes {expression.strip()}, and {digits} {nobody} prints, holds or asserts"
        derived.add(float(eval(expression, {"__builtins__": {}}, {"sqrt": math.sqrt, "pi": math.pi})))
    for digits, unit in claims(text):
        if not backed(digits, unit, known | derived):
            yield f"says {digits}{unit}, which {nobody} prints, holds or asserts"
    for kind, phrase, value, low, high in worded(text):
        if not (kind == "part" and value in known and re.search("degree|met|pix", phrase)) and not any(
            low <= size <= high for size in derived
        ):
            yield f"says '{phrase}', which no 'given' or 'so' of its cell backs"


def claims(text):
    """The numbers of a piece of prose as (digits, unit), those that need no backing left out."""
    text = SHAPE.sub(" ", LABEL.sub(" ", plain_text(text)))
    for found in DIGITS.finditer(text):
        unit = UNIT.match(text, found.end())
        digits, unit = found[0], unit[0].strip(" -") if unit else ""
        if unit:
            free = unit in ("°", "deg", "degrees") and number_of(digits) in QUARTERS
        else:
            free = free_count(digits) or re.fullmatch(r"(19|20)\d\d", digits)
        if not free:
            yield digits, unit


def free_count(digits):
    return number_of(digits) <= SMALL and number_of(digits).is_integer()


def worded(text):
    """The claims in words of a piece of prose: (its kind, the phrase, its value, from where, to where it is true)."""
    text = plain_text(text)
    for pattern in NO_CLAIM:
        text = pattern.sub(" ", text)
    for found in WORDS.finditer(text):
        bound, phrase = (found["bound"] or "").strip().lower(), found[0].strip()
        kind = next(kind for kind in KINDS if found[kind])
        for value in sizes(found[kind].lower()):
            low, high = 0.88 * value, 1.12 * value
            if bound in ("more than", "over"):
                low, high = value, 1.6 * value
            elif bound:
                low, high = 0.7 * value, value
            yield kind, phrase, value, low, high


def sizes(words):
    """The one or two numbers that some words tell: 'three quarters', 'ten to thirty times', 'twice'."""
    if words in MULTIPLES:
        return [MULTIPLES[words]]
    part = re.search(rf"({PART})s?$", words)
    if part:
        return [COUNTS.get(words[: part.start()].strip(), 1) / PARTS[part[1]]]
    return [COUNTS.get(word) or float(word) for word in re.split(" to | or ", words.removesuffix(" times"))]


def plain_text(text):
    """The prose of a piece of Markdown, on one line: no formulas, code, comments, headings' numbers."""
    for pattern in NOT_PROSE:
        text = pattern.sub(" ", text)
    return " ".join(text.split())


def values(text):
    """The sizes of the numbers in code or in an output, without their signs; a percentage as a share, too."""
    found = re.findall(r"(?<![\w.#])(\d[\d_]*(?:\.\d+)?(?:e-?\d+)?)( ?%| ?per ?cent)?", text)
    numbers = [(float(digits.replace("_", "")), percent) for digits, percent in found]
    return {value for value, _ in numbers} | {value / 100 for value, percent in numbers if percent}


def backed(digits, unit, known):
    """Is the number one of the known ones, rounded to the digits that the prose gives, perhaps in another unit?"""
    mantissa, _, power = re.sub(r"[ \u00a0\u202f]", "", digits).partition("e")
    half = 0.5 * 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2])) * (1 + 1e-9) + 1e-20
    value, scales = number_of(digits), SCALES.get(unit, (1.0,))
    return any(abs(known_value * scale - value) <= half for known_value in known for scale in scales)


def number_of(digits):
    return float(re.sub(r"[ \u00a0\u202f]", "", digits))


#: The pages that tell numbers of the arm, besides the chapters.
PAGES = ("book/errata.md", "book/files.md", "book/glossary.md", "book/notation.md")


def of_pages(paths=PAGES):
    """What is wrong with the numbers of pages, as lines `name, line n: what`."""
    found = ((path, page_problems((ROOT / path).read_text(encoding="utf-8"))) for path in paths)
    return [f"{path}, line {number}: {what}" for path, problems in found for number, what in problems]


def of_chapters(paths):
    found = ((path, problems(normalise.read(path)["cells"])) for path in paths)
    return [f"{path.name}, cell {number}: {what}" for path, wrong in found for number, what in wrong]


@in_a_sentence
def main(argv=None):
    named = argv or []
    pages = [name for name in named if name.endswith(".md")]
    chapters = [name for name in named if name not in pages]
    found = of_chapters(normalise.chapters(chapters)) if chapters or not named else []
    found += of_pages(pages if named else PAGES)
    print("\n".join(found) or "Every number in prose is backed.")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
