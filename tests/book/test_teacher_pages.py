"""The pages for teachers say what the chapters hold, and the plans fit into their meetings."""

import re

import numpy as np
import pytest

import omx
from book.chapters import normalise
from book.publish import teacher_pages
from book.setup.paths import ROOT
from omx.hardware.log import read_log
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort, World, cube
from tests.helpers.chapter import chapter

FOUND = {found.name: found for found in teacher_pages.chapters()}
PLANS = teacher_pages.told()["plans"]


@pytest.mark.parametrize("name", FOUND)
def test_a_chapter_says_what_a_teacher_asks(name):
    found = FOUND[name]
    assert len(found.objectives) == 3
    assert all(objective.startswith("**") for objective in found.objectives)
    assert 15 <= found.slides_min <= teacher_pages.ROOM_MIN
    assert found.reading_min >= found.slides_min / 2
    assert found.told["mistakes"]
    assert found.told["skip"]
    for exercise in found.exercises:
        assert exercise.number, exercise
        assert 1 <= exercise.difficulty <= 5, exercise
        assert 5 <= exercise.minutes <= 60, exercise
    assert sum(exercise.points for exercise in found.exercises) >= len(found.exercises) - 1, "one answer in words"


@pytest.mark.parametrize(("count", "meetings"), PLANS.items())
def test_a_plan_fits_its_meetings(count, meetings):
    assert len(meetings) == int(count)
    for number, meeting in enumerate(meetings, 1):
        assert teacher_pages.minutes(meeting, FOUND) <= teacher_pages.ROOM_MIN, f"meeting {number}"
        assert meeting["point"]


@pytest.mark.parametrize("meetings", PLANS.values(), ids=PLANS)
def test_no_chapter_is_met_twice_and_no_half_is_left(meetings):
    shares = {}
    for share, name in (part for meeting in meetings for part in map(teacher_pages.taken, meeting["chapters"])):
        shares[name] = shares.get(name, 0) + share
    assert max(shares.values()) == 1
    if len(meetings) > 4:
        assert set(shares.values()) == {1}


def test_fifteen_meetings_are_the_whole_book():
    planned = {name for meeting in PLANS["15"] for _, name in map(teacher_pages.taken, meeting["chapters"])}
    assert set(FOUND) <= planned


def test_numbers_come_from_the_cells(tmp_path):
    path = tmp_path / "31-lines.ipynb"
    normalise.write(path, normalise.normalise({"cells": chapter(), "nbformat": 4}))
    found = teacher_pages.Chapter(path, {"mistakes": ["Adding what should be multiplied."]})
    text = teacher_pages.section(found)
    assert found.title in text
    assert "Adding what should be multiplied." in text
    assert all(exercise.title in text for exercise in found.exercises)
    assert found.link() in teacher_pages.overview([found])
    meeting = {"chapters": ["1/2 lines", "not-yet-written"], "point": "p"}
    row = teacher_pages.plan([meeting], {"lines": found}).splitlines()[-1]
    assert f"{found.link()} (first part); Not yet written" in row


def test_the_clock_of_the_labs_goes_forward_and_every_group_gets_its_turn():
    text = (ROOT / "book/teach/labs.md").read_text(encoding="utf-8")
    tables = re.findall(r"\*\*(?:One arm|Two arms|Four arms)\*\*.*?\n\n(.*?)\n\n", text, re.DOTALL)
    assert len(tables) == 3
    for table, arms in zip(tables, (1, 2, 4), strict=True):
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
        times = [re.findall(r"(\d):(\d\d)", row[0]) for row in rows if ":" in row[0]]
        flat = [60 * int(h) + int(m) for pair in times for h, m in pair]
        assert flat == sorted(flat)
        assert flat[-1] == teacher_pages.MEETING_MIN
        places = (1, 3) if arms == 1 else range(1, arms + 1)
        turns = [row[place] for row in rows for place in places if row[place] in "ABCD" and row[place]]
        assert sorted(turns) == list("ABCD")


def test_an_afternoon_gives_every_group_both_labs_and_the_arms_a_pause():
    text = (ROOT / "book/teach/labs.md").read_text(encoding="utf-8")
    (table,) = re.findall(r"\*\*Two arms, an afternoon\*\*.*?\n\n(.*?)\n\n", text, re.DOTALL)
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
    spans = [[60 * int(h) + int(m) for h, m in re.findall(r"(\d):(\d\d)", row[0])] for row in rows if ":" in row[0]]
    flat = [minute for span in spans for minute in span]
    assert flat == sorted(flat)
    turns = [turn for row in rows for cell in row[1:3] for turn in re.findall(r"([A-D]), chapter (\d+)", cell)]
    assert sorted(turns) == [(group, chapter) for group in "ABCD" for chapter in ("10", "11")]
    for start, end, *cells in [(*span, *row[1:]) for span, row in zip(spans, rows[2:], strict=True)]:
        assert end - start == 35 or not re.search("chapter", cells[0])


def test_the_program_for_the_lab_does_and_logs_what_the_page_says(tmp_path, monkeypatch):
    """The page's own lines on the virtual arm: their times, and what the page says of each column of the log."""
    page = (ROOT / "book/teach/labs.md").read_text(encoding="utf-8")
    program = re.search(r"```python\n(import numpy.*?)```", page, re.DOTALL)[1]
    arm = VirtualArm(q=omx.HOME)
    world = World(arm, [cube("red", (125, 85), yaw_deg=34)])
    names = {"PORT": VirtualPort(arm, SteppedClock())}
    monkeypatch.chdir(tmp_path)
    exec(program.replace('Robot("auto")', "Robot(PORT)"), names)
    robot, now = names["robot"], names["robot"].clock.now
    robot.write_motor_state(True)
    robot.move_to(np.degrees(omx.HOME))
    times = [now()]
    with names["Recorder"]("pick-1.csv", names["COLUMNS"]) as recorder:
        for act in (names["pick"], names["put"]):
            act((125, 85), recorder)
            times.append(now())
    robot.park()
    told = re.search(r"a pick takes (\S+) s, a put (\S+) s, parking (\S+) s", page).groups()
    assert np.diff([*times, now()]) == pytest.approx([float(seconds) for seconds in told], abs=0.35)
    assert np.linalg.norm(world["red"].at - [125, 85, 15]) < 2
    assert world["red"].standing
    t, x, y, z, i2, opening, force = read_log(tmp_path / "pick-1-2.csv").array(*names["COLUMNS"]).T
    low, held = z < 60, opening < 35
    assert opening[[0, -1]] == pytest.approx(60.0, abs=0.1)
    assert opening[held] == pytest.approx(29.9, abs=0.1)
    assert force[held] == pytest.approx(10.0, abs=0.5)
    assert max(np.ptp(x[low]), np.ptp(y[low])) < 1
    assert z.min() == pytest.approx(38.6, abs=0.1)
    steps = np.diff(t)
    assert np.median(steps) == pytest.approx(0.04)
    assert np.count_nonzero(steps > 0.5) == 2
    falls = np.gradient(z) < 0
    at_60 = [abs(z - 60) + 1e3 * ~way for way in (falls & ~held, falls & held, ~falls & held)]
    empty, down, up = (i2[gap.argmin()] for gap in at_60)
    assert empty - down == pytest.approx(16, abs=3)
    assert down - up == pytest.approx(110, abs=10)
