"""The report as Markdown: the verdicts first, then every family with its tables and what was left out."""

from tests.bench.sheet import NOT_AS_EXPECTED, Section, Table


def written(facts: list[tuple[str, str]], sections: list[Section], figure: str) -> str:
    """The whole text. `facts`: name and value of what describes the run; `figure`: the picture's file name."""
    failed = [f"{e.what}: {e.measured}, expected {e.limit}" for s in sections for e in s.expectations if not e.holds]
    parts = [
        "# Benchmark",
        table(Table("", ("", ""), facts)),
        "## Verdicts",
        f"{len(failed)} of {sum(len(s.expectations) for s in sections)} expectations were not met"
        + (":\n\n" + bullets(failed) if failed else "."),
        f"![Ratios and times of this run; the tables below hold every number]({figure})",
        *(part for section in sections for part in _section(section)),
    ]
    return "\n\n".join(parts) + "\n"


def _section(section: Section):
    yield f"## {section.title}"
    yield section.prose.replace("\n", " ")
    if section.expectations:
        rows = [(e.what, e.limit, e.measured, _loud(e.verdict)) for e in section.expectations]
        yield table(Table("", ("what", "expected", "measured", "verdict"), rows))
    for each in section.tables:
        yield f"**{each.title}**"
        yield table(each)
    if section.left_out:
        yield "Left out:\n\n" + bullets(section.left_out)


def table(content: Table) -> str:
    """A table; numbers are text already."""
    lines = [content.head, ("---",) * len(content.head), *content.rows]
    return "\n".join("| " + " | ".join(_cell(cell) for cell in line) + " |" for line in lines)


def bullets(lines: list[str]) -> str:
    return "\n".join(f"- {_cell(line)}" for line in lines)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def _loud(verdict: str) -> str:
    return f"**{verdict}**" if verdict == NOT_AS_EXPECTED else verdict
