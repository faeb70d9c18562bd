"""What a slide must keep so that the last row can read it: `python run.py slides --check` looks at every deck.

    python -m book.publish.slide_lint                   # all decks in build/slides
    python -m book.publish.slide_lint build/slides/03*  # these

Nothing leaves the slide, at most 75 words, type large enough for what it shows (`LEAST`), no slide with only a heading,
and no code without a sentence that says what it is for. Needs Chromium or Chrome.
"""

import functools
import sys
from collections import Counter
from pathlib import Path

from book.publish import handout
from book.setup.paths import BUILD, Stop

MOST_WORDS = 75
#: The smallest type (of 720 px) that can be read with the slide 320 px wide, which is a screen from the last row; by
#: what is set in it: where that stands, how small it may be, and what helps.
LEAST = {
    "code": (".code", 26, "cut its lines, or leave the cell to the page (slide_type skip) and say what it does"),
    "printed text": (".output", 22, "print fewer columns or lines"),
    "a formula": ("mjx-container", 22, "break it into two, or name a part of it"),
    "a table": ("table:not(.omx-answer *)", 22, "fewer columns or words"),
    "type": ("section", 18, "fewer words"),
}

#: What each slide shows, all fragments on: its size beyond the slide (px), words, and the smallest type (px) of each
#: of the kinds `least`, with the notebook's cell.
MEASURE = """(least) => {
  Reveal.configure({ transition: "none" });
  const skipped = "aside, pre, mjx-container, svg, .omx-scene, .omx-plot, .omx-controls, .omx-note, .katex";
  const word = /[\\p{L}]/u;
  const own = (node) => [...node.childNodes].some((c) => c.nodeType === 3 && c.data.trim());
  return Reveal.getSlides().map((slide) => {
    const { h, v } = Reveal.getIndices(slide);
    Reveal.slide(h, v, 99);
    const parts = [...slide.querySelectorAll("*")].filter((c) => !c.closest("aside, mjx-container, svg, .omx-scene"));
    const seen = parts.filter((c) => c.offsetWidth && c.offsetHeight);
    const box = slide.getBoundingClientRect(), scale = box.width / 1280;
    const edges = [...seen, ...slide.querySelectorAll("mjx-container svg")].filter((c) => !c.closest("aside"))
      .map((c) => c.getBoundingClientRect());
    const wide = seen.filter((c) => c.matches("pre, table, .formula, p, li") && c.scrollWidth > c.clientWidth + 3);
    const texts = seen.filter((c) => own(c) && !c.matches("sub, sup"));
    const formulas = [...slide.querySelectorAll("mjx-container")].filter((c) => !c.closest("aside"));
    const type = [...texts, ...formulas].map((c) => [parseFloat(getComputedStyle(c).fontSize), c]);
    const smallest = Object.entries(least).map(([kind, [where]]) => {
      const [px, node] = type.filter(([, c]) => c.closest(where)).reduce((a, b) => (b[0] < a[0] ? b : a), [99, null]);
      return [kind, { px, cell: node?.closest("[data-cell]")?.dataset.cell ?? "" }];
    });
    const rect = (c) => c.getBoundingClientRect();
    const images = [...slide.querySelectorAll(".omx-scene, img:not(.omx-scene img)")].map((c) => [c, rect(c)]);
    const lines = seen.filter((c) => c.matches("p, li, pre, td, h1, h2, h3") && !c.closest(".omx-controls"));
    const beside = (a, b) => a.right < b.left + 3 || b.right < a.left + 3;
    const apart = (a, b) => beside(a, b) || a.bottom < b.top + 3 || b.bottom < a.top + 3;
    const things = [...slide.querySelectorAll("pre, mjx-container, img, .omx-scene, .omx-plot")];
    const clone = slide.cloneNode(true);
    for (const c of clone.querySelectorAll(skipped)) c.remove();
    const words = (node) => node.textContent.split(/[\\s\\u2009]+/).filter((w) => word.test(w)).length;
    const all = words(clone);
    for (const c of clone.querySelectorAll("h1, h2, h3, .again")) c.remove();
    return {
      title: slide.querySelector("h1, h2, h3, .again")?.textContent ?? slide.innerText.slice(0, 40),
      below: Math.max(0, ...edges.map((e) => (e.bottom - box.top) / scale - 720)),
      right: Math.max(0, ...edges.map((e) => (e.right - box.left) / scale - 1280)),
      covered: images.some(([c, place]) => lines.some((line) => !c.contains(line) && !apart(place, rect(line)))),
      cut: wide.length, words: all, smallest: Object.fromEntries(smallest),
      bare: !words(clone) && !things.some((c) => !c.closest("aside, h1, h2, h3")),
      unsaid: !!slide.querySelector(".code") && !clone.querySelector("p, li, td"),
      notes: (slide.querySelector("aside.notes")?.textContent ?? "").split(/\\s+/).length - 1,
    };
  });
}"""

#: The faults of a slide, by what is said of it.
FAULTS = {
    "leaves the slide": lambda s: s["below"] > 1 or s["right"] > 1 or s["cut"],
    "words under a picture": lambda s: s["covered"],
    f"more than {MOST_WORDS} words": lambda s: s["words"] > MOST_WORDS,
    **{
        f"{kind} under {px} px": functools.partial(lambda kind, px, s: s["smallest"][kind]["px"] < px - 0.05, kind, px)
        for kind, (_, px, _) in LEAST.items()
    },
    "only a heading": lambda s: s["bare"],
    "code without a sentence": lambda s: s["unsaid"],
}


def faults(slide):
    """What is wrong with a slide, given what `MEASURE` saw of it."""
    return [name for name, is_so in FAULTS.items() if is_so(slide)]


def measure(page):
    """What each slide of the deck shows that is open and ready in `page`, in order."""
    return page.evaluate(MEASURE, LEAST)


def problems(name, slides):
    """Lines `03-... slide 4 (its heading): what is wrong`, with what was measured, or where it is and what helps."""
    for number, slide in enumerate(slides, 1):
        for fault in faults(slide):
            seen = f"{slide['words']} words, {slide['below']:.0f} px below, {slide['right']:.0f} px right"
            if (kind := fault.partition(" under ")[0]) in LEAST:
                small, (*_, advice) = slide["smallest"][kind], LEAST[kind]
                seen = f"{small['px']:.1f} px{' in cell ' * bool(small['cell'])}{small['cell']}; {advice}"
            yield f"{name}, slide {number} ({slide['title'][:40]}): {fault}: {seen}"


def look(decks):
    """The slides of each deck, by its name, as a browser shows them. Raises `Stop` without a browser."""
    seen = {}
    with handout.chromium() as running:
        for deck in decks:
            page = running.new_page(viewport={"width": 1280, "height": 720})
            page.set_default_timeout(handout.PATIENCE_MS)
            page.add_init_script(handout.NO_SCENES)
            page.goto(deck.as_uri())
            page.wait_for_selector("body[data-ready]")
            seen[deck.stem] = measure(page)
            page.close()
    return seen


def report(seen):
    """The lines of a table: how many slides, words, and the share of each fault."""
    slides = [slide for deck in seen.values() for slide in deck]
    counts = Counter(fault for slide in slides for fault in faults(slide))
    words = sum(slide["words"] for slide in slides) / len(slides)
    yield f"{len(slides)} slides in {len(seen)} decks, {words:.0f} words a slide"
    for name in FAULTS:
        yield f"{counts[name]:5} {100 * counts[name] / len(slides):5.1f} %  {name}"
    quiet = sum(not s["notes"] for s in slides)
    yield f"{quiet:5} {100 * quiet / len(slides):5.1f} %  without a note"


def check(decks):
    """Print what is wrong with these decks; how many faults."""
    seen = look(decks)
    found = [line for name, slides in seen.items() for line in problems(name, slides)]
    print("\n".join([*found, *report(seen)]))
    return len(found)


def main(argv):
    decks = [Path(name) for name in argv] or sorted((BUILD / "slides").glob("[0-9]*.html"))
    try:
        return 1 if check([deck.resolve() for deck in decks if deck.suffix == ".html"]) else 0
    except Stop as error:
        print(f"slides: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
