"""The benchmark runs, times what it says, and judges by ratios; its report has all that it promises."""

import os
import re
import subprocess
import sys
import time

import numpy as np
import pytest
from PIL import Image

from book.setup import extra_envs
from omx.generated import fk, ik
from tests.bench import machine, rivalry, sheet
from tests.bench.ask import Absent, ask, verdict
from tests.bench.c_code import compiled, only
from tests.bench.contenders import in_c, many, one_at_a_time
from tests.bench.peer import Task, grow
from tests.bench.peers import PEERS
from tests.bench.peers.contest import Contest, agreed
from tests.bench.report import report
from tests.bench.timing import Contender, Result, clock, race
from tests.helpers import oracles


def test_every_contender_runs_and_every_ratio_has_its_reference():
    few_in_c, many_in_c = in_c(1000)
    for contenders in (one_at_a_time(few_in_c), [*many(1000), *many_in_c]):
        names = [contender.name for contender in contenders]
        assert len(set(names)) == len(names)
        for result in race(contenders, rounds=1):
            assert result.ns > 0
            assert (result.ratio is None) == (result.contender.against not in names)


def busy(milliseconds):
    def call():
        end = clock() + milliseconds / 1000
        while clock() < end:
            pass

    return call


def test_twice_the_work_is_a_ratio_of_two():
    _, double = race([Contender("one", busy(1)), Contender("two", busy(2), "one", at_most=1.5)], rounds=9)
    assert double.ratio == pytest.approx(2, rel=0.2)
    assert double.verdict == "NOT as expected"


def test_work_of_other_threads_is_timed_by_the_wall():
    sleeps = Contender("two", lambda: time.sleep(0.01), "one", threads=2)
    _, slept = race([Contender("one", busy(5)), sleeps], rounds=5)
    assert slept.ratio > 0.1  # by its own processor time it would be 0.001
    assert slept.ns >= 10e6


@pytest.mark.parametrize(
    ("at_most", "absolute", "verdict"),
    [(None, False, ""), (0.6, False, "as expected"), (0.4, False, "NOT as expected"), (90.0, True, "NOT as expected")],
)
def test_verdicts(at_most, absolute, verdict):
    contender = Contender("omx", lambda: None, "reference", at_most, absolute)
    assert Result(contender, ns=100.0, ratio=0.5).verdict == verdict


def test_one_branch_is_that_branch():
    target = (200.0, 50.0, 150.0, -0.3, *oracles.COURSE)
    assert only(ik.branches, "back_up")(*target) == ik.branches(*target)[2]


def test_c_is_the_same_formula():
    made = compiled([fk.pose, ik.branches, fk.transform])
    if made is None:
        pytest.skip("no C compiler")
    ffi, lib = made
    for q in oracles.any_q(20).tolist():
        for name, function in (("pose", fk.pose), ("transform", fk.transform)):
            out = ffi.new("double[]", 16)
            getattr(lib, name)(*q, *oracles.COURSE, out)
            expected = np.ravel(function(*q, *oracles.COURSE))
            np.testing.assert_allclose(list(out)[: len(expected)], expected, atol=1e-12)


# ---- the report --------------------------------------------------------------------------------------------


def contest(rows):
    """Twice our work; beyond 100 rows somebody is wrong."""
    return Contest(
        [Contender("ours", busy(2), count=rows)], [Contender("theirs", busy(4), count=rows)], agreed(rows / 1e8)
    )


def test_a_peer_is_measured_against_ours_until_it_takes_too_long():
    found = {"races": [], "left_out": []}
    grow("FK, batch", contest, (10, 100), Task((), 0.1, longest_s=0.03), found)
    (measured,) = found["races"]
    ours, theirs = measured["results"]
    assert (measured["rows"], measured["gap"]) == (10, 1e-7)
    assert (ours["theirs"], theirs["theirs"], theirs["best"]) == (False, True, "ours")
    assert theirs["to_ours"] == pytest.approx(2, rel=0.3)
    assert verdict(theirs).startswith("beaten: takes 2")
    assert re.fullmatch(r"FK, batch, 100 rows and more: one pass would take about 0\.0 s", found["left_out"][0])


def test_what_is_not_the_same_work_is_not_timed():
    found = {"races": [], "left_out": []}
    grow("FK, batch", contest, (1000,), Task((), 0.1, 60.0), found)
    assert found == {"races": [], "left_out": ["FK, batch, 1,000 rows: AssertionError: the results differ by 1.0e-05 "
                                               "mm or rad (in agreed)"]}  # fmt: skip


def test_who_is_faster_than_we_is_not_called_beaten():
    assert verdict({"to_ours": 0.5}) == "not beaten: by 2x"


def test_a_peer_that_cannot_be_installed_is_named_with_what_the_installer_said(tmp_path, monkeypatch):
    pins = tmp_path / "environment.txt"
    pins.write_text("#: peer-ikpy ikpy==0.0.0.0.1\n", encoding="utf-8")
    monkeypatch.setattr(extra_envs, "ENVIRONMENT", pins)
    monkeypatch.setattr(extra_envs, "ROOT", tmp_path)
    with pytest.raises(Absent, match=r"Making an environment failed \(.{10}"):
        ask("ikpy", Task((10,), 0.1, 0.1), sheet.FULL)
    monkeypatch.setattr(rivalry, "PEERS", {"ikpy": PEERS["ikpy"]})
    section = rivalry.measure(sheet.FULL)
    assert section.tables == section.expectations == section.panels == []
    assert re.fullmatch(r"ikpy: Making an environment failed \(.*", section.left_out[0])


def test_every_peer_has_its_pins_and_no_package_has_two():
    known = {}
    for line in extra_envs.ENVIRONMENT.read_text(encoding="utf-8").splitlines():
        for requirement in line.split("  #")[0].split()[2:] if line.startswith("#: ") else ():
            name, version = re.fullmatch(r"([\w.\[\]-]+)==([\w.]+)", requirement).groups()
            assert known.setdefault(name, version) == version, f"{name} is pinned to {version} and to {known[name]}"
    for peer in PEERS.values():
        assert not peer.environment or extra_envs.requirements(peer.environment)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows does not tell what children have used")
def test_the_others_are_who_works_besides_us():
    watch = machine.Watch()
    busy(200)()
    alone = watch.others()
    with subprocess.Popen([sys.executable, "-c", "while True: pass"]) as other:  # counts as ours only when it has ended
        watch = machine.Watch()
        time.sleep(1.0)
        crowded = watch.others()
        other.kill()
    assert 0.0 <= alone <= 1.0
    assert crowded > 0.3 / os.cpu_count()


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """The small report's text and its picture."""
    path = report(quick=True, folder=tmp_path_factory.mktemp("bench"))
    return path.read_text(encoding="utf-8"), path.with_suffix(".png")


def test_the_report_has_every_section_and_says_on_what_it_was_measured(small):
    text, _ = small
    titles = re.findall("^## (.+)$", text, re.M)
    assert [title.split(":")[0] for title in titles] == [
        "Verdicts", "Batches", "Peers", "Growth with the joints", "Workspace maps", "The book", "The book"
    ]  # fmt: skip
    assert machine.processor() in text
    assert f"numpy {np.__version__}" in text


def test_the_report_names_every_peer_measured_or_left_out(small):
    text, _ = small
    for name in PEERS.keys() - {"omx"}:
        assert re.search(rf"^(\| {name} \| beaten \| .*(beaten|measured).*|- {name}.*: .+)$", text, re.M)
    assert re.search(r"\| beaten: takes [\d.,]+x as long \|", text)
    assert re.search(r"\| as expected \|", text)


def test_the_numbers_of_the_report_are_positive(small):
    text, _ = small
    numbers = re.findall(r"(-?[\d.,]+(?:e[-+]\d+)?) ?(?:x|ns|us|ms|s|MB)(?= [|]|,|:)", text)
    assert len(numbers) > 50
    assert all(float(number.strip(",").replace(",", "")) > 0 for number in numbers)


def test_the_figure_is_a_picture_with_something_in_it(small):
    _, path = small
    with Image.open(path) as picture:
        assert picture.width > 1000
        assert len(picture.convert("L").getcolors(256)) > 20
