"""What of a chapter's prose is for the screen, and what is for the speaker to say.

On the screen stand headings, displayed formulas, tables and lists, and of each paragraph and each item of a list its
first sentence and the sentences with a **bold** word. A sentence that leads on, with a colon at its end, stays before
a formula or a list; one that points back (It, So, This ...) brings along the one before it, and a first sentence of
fewer than five words the one after it. Where a slide shows nothing but prose, more of it stays. A Predict and a
numbered question stay whole; answers in <details>, and what stands in parentheses, are only said. Wherever the screen
shows less than all, the whole paragraph is in the notes.
"""

import copy
import re
from itertools import pairwise

from markdown_it.token import Token

#: Words of a first sentence that stands alone; words of a slide that shows nothing else.
SHORTEST, ENOUGH = 5, 30
ATOM = re.compile(r"`[^`]*`|\$[^$]+\$|!?\[[^\]]*\]\([^)]*\)")
HIDDEN = re.compile("\ue000(\\d+)\ue001")
END = re.compile(r"[.!?][*_)”\"’]*\s+(?=[*_(“\"]*[A-Z\ue000])")
HEAD = re.compile(r"(\*{1,2})[^*]+[.:!?]\1|\d+\.|\*\*Errata\*\*[^.]*\.")
NUMBERED = re.compile(r"\*\*\d+\.\*\*")
DETAILS = re.compile(r"</?details\b")
PARAGRAPH, END_OF_PARAGRAPH = Token("paragraph_open", "p", 1), Token("paragraph_close", "p", -1)
COMMENT = re.compile(r"<!--.*?-->\n?", re.DOTALL)
POINTS_BACK = re.compile(
    r"\W*(It|Its|They|Their|This|That|These|Those|Here|There|Both|Each|One|Neither|Such|At such|Together|Instead|So|But"
    r"|And|Then|Therefore|Because|Only|Even|The (other|second|last)|(With|From) (it|there|them|this))\b"
)
ANSWERS = re.compile(r"(Because|Yes|No|Not)\b")


def sentences(text):
    """A paragraph of Markdown, cut behind each sentence; a bold or emphasised head belongs to the sentence after it."""
    atoms = ATOM.findall(text)
    numbers = iter(range(len(atoms)))
    masked = ATOM.sub(lambda _: f"\ue000{next(numbers)}\ue001", text)
    cuts = [0, *(found.end() for found in END.finditer(masked)), len(masked)]
    out = []
    for start, end in pairwise(cuts):
        piece = HIDDEN.sub(lambda m: atoms[int(m[1])], masked[start:end]).strip()
        if out and HEAD.fullmatch(out[-1]):
            out[-1] += " " + piece
        elif piece:
            out.append(piece)
    return out


def shown(text, leads=False, least=0):
    """The sentences of a paragraph that stand on the screen, of `least` words or more if there are as many.

    `leads`: a formula or a list follows it.
    """
    said = sentences(text)
    if NUMBERED.match(text):
        return said
    said = [sentence for sentence in said if not (sentence.startswith("(") and sentence.endswith(")"))]
    if not said or (text.startswith("(") and text.endswith(")")):
        return []
    keep = {i for i, sentence in enumerate(said) if i == 0 or "**" in sentence}
    if leads and said[-1].endswith(":"):
        keep.add(len(said) - 1)
    if len(said) > 1 and len(said[0].split()) < SHORTEST and not said[0].endswith("?"):
        keep.add(1)
    for i in range(1, len(said)):
        if len(" ".join(said[:i]).split()) < least or (i - 1 in keep and ANSWERS.match(said[i])):
            keep.add(i)
    for i in range(len(said) - 1, 0, -1):
        if i in keep and POINTS_BACK.match(said[i]):
            keep.add(i - 1)
    return [said[i] for i in sorted(keep)]


def split(tokens, parse_inline, whole=False, alone=False):
    """Tokens of markdown-it: those for the screen, and whole paragraphs of which less or nothing stands there.

    `whole`: paragraphs stay as they are; answers in <details> are said all the same. `alone`: the slide shows nothing
    else. The last sentence of a paragraph is marked, for a slide that goes on to repeat it.
    """
    least = ENOUGH / max(1, sum(t.type == "paragraph_open" for t in tokens)) if alone else 0
    on_screen, said, answers, inside = [], [], 0, False
    for i, token in enumerate(tokens):
        if token.type == "html_block" and DETAILS.search(token.content):
            inside = "</details" not in token.content
            answers += inside
        elif inside:
            first = token.type == "inline" and tokens[i - 2].type == "html_block"
            said.append(inline(token, f"**{answers}.** {token.content}", parse_inline) if first else token)
        elif token.type == "inline" and tokens[i - 1].type == "paragraph_open" and not whole:
            text = token.content.strip()
            leads = i + 2 < len(tokens) and leads_on(tokens[i + 2])
            kept = [] if after_objectives(tokens, i) else shown(text, leads, least)
            if kept != sentences(text):
                said += [PARAGRAPH, token, END_OF_PARAGRAPH]
            if len(kept) > 1:
                kept[-1] = f'<span class="last">{kept[-1]}</span>'
            on_screen.append(inline(token, " ".join(kept), parse_inline))
        else:
            on_screen.append(token)
    return without_empty(on_screen), said


def after_objectives(tokens, i):
    """Does the text stand behind the list of a chapter's first cell? What one needs to know before is not shown."""
    return tokens[0].tag == "h1" and tokens[i].level == 1 and any(t.type == "bullet_list_close" for t in tokens[:i])


def leads_on(token):
    return token.type.startswith(("math_block", "amsmath", "bullet_list_open", "ordered_list_open", "table_open"))


def inline(token, text, parse_inline):
    """The inline token with another text."""
    token = copy.copy(token)
    token.content, token.children = text, parse_inline(text)[0].children if text else []
    return token


def without_empty(tokens):
    """Without paragraphs that say nothing any more."""
    out = []
    for token in tokens:
        out.append(token)
        if [t.type for t in out[-3:]] == ["paragraph_open", "inline", "paragraph_close"] and not out[-2].content:
            del out[-3:]
    return out
