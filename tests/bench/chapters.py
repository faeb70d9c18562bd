"""How long the chapters run, and how long the site takes to build, in a copy of the book that nobody else uses."""

import shutil
import subprocess
import sys
import time
from pathlib import Path

from book.publish import runs
from book.setup.paths import ROOT, child_environment
from tests.bench.sheet import Expectation, Panel, Section, Size, Table, at_most, duration

LIMIT_S, SITE_TIMEOUT_S = 20.0, 300
COPIED = ("book", "notebooks", "omx", "environment.txt")

PROSE = """Each chapter ran alone in a fresh kernel, whose start is included. The site was then built from nothing in a
copy of the book, from these runs: every page, the slides, the start page."""


def copied(folder: Path) -> Path:
    """What the site is made of, copied to `folder`; the libraries that npm fetched are shared."""
    folder.mkdir()
    for name in COPIED:
        source, target = ROOT / name, folder / name
        if source.is_dir():
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__", ".ipynb_checkpoints"))
        else:
            shutil.copyfile(source, target)
    (folder / "build").mkdir()
    if (ROOT / "build" / "npm").exists():
        shutil.copytree(ROOT / "build" / "npm", folder / "build" / "npm", symlinks=True)
    return folder


def measure(size: Size, folder: Path) -> Section:
    """`folder`: of the copy; its site is left there for those who weigh the pages."""
    section = Section("The book: chapters and site", PROSE)
    paths = runs.chapters() if size.whole else runs.chapters()[:1]
    seconds, package = {}, runs.fingerprint_of_package()
    for path in paths:
        start = time.perf_counter()
        try:
            runs.run(path, package, folder / "build" / "executed")
        except runs.execute.Failed as error:
            section.left_out.append(f"{path.stem}: it failed at cell {error.number}: {error.reason.splitlines()[-1]}")
            continue
        seconds[path.stem] = time.perf_counter() - start
    if not size.whole:
        section.left_out.append("the other chapters, and the site: --quick")
    rows = [(name, duration(value)) for name, value in seconds.items()]
    section.tables.append(Table("Time of one run", ("chapter", "time"), rows))
    if seconds:
        slowest = max(seconds, key=seconds.get)
        section.expectations.append(
            at_most(f"the slowest of {len(seconds)} chapters, {slowest}", seconds[slowest], LIMIT_S, " s")
        )
        section.panels.append(Panel("Chapters", "time of one run (s)", "", {}, seconds, LIMIT_S))
    if size.whole:
        section.expectations.append(_site(section, folder))
    return section


def _site(section: Section, folder: Path) -> Expectation:
    """The site, built in the copy."""
    start = time.perf_counter()
    try:
        done = subprocess.run([sys.executable, "-m", "book.publish.site"], cwd=folder, env=child_environment(),
                              capture_output=True, text=True, timeout=SITE_TIMEOUT_S, check=False)  # fmt: skip
        said = (done.stderr or done.stdout).strip().splitlines()
        status, last = done.returncode, said[-1][:200] if said else ""
    except subprocess.TimeoutExpired:
        status, last = 1, f"stopped after {SITE_TIMEOUT_S} s"
    took = time.perf_counter() - start
    if status:
        section.left_out.append(f"the site: {last}")
        return Expectation("the site is built without a warning", "built", f"not built: {last}", False)
    section.tables.append(Table("Site", ("", "time"), [("from nothing, the chapters' runs kept", duration(took))]))
    return Expectation("the site is built without a warning", "built", f"built in {duration(took)}", True)
