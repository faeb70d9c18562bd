"""Logs: what is written is read back to the last bit, and nothing that was sampled is lost."""

import io
import math
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omx
from omx.errors import BadInput, LogError
from omx.hardware.clock import SteppedClock, ticks
from omx.hardware.log import ProgressBar, Recorder, read_log, write_log

COLUMNS = {"t": "s", "q1": "deg", "current1": "mA"}


def test_a_log_reads_back_to_the_last_bit(tmp_path):
    rng = np.random.default_rng(3)
    samples = rng.normal(size=(100, 3)) * 10.0 ** rng.integers(-300, 300, (100, 3))
    with Recorder(tmp_path / "run.csv", COLUMNS, omx.MAKER, program="lab 2") as recorder:
        for sample in samples:
            recorder.write(*sample)
    log = read_log(tmp_path / "run.csv")
    assert log.samples == [tuple(s) for s in samples.tolist()]
    assert log.units == COLUMNS
    assert log.notes == {"program": "lab 2"}
    assert log.geometry == omx.MAKER
    assert log.geometry.name == "maker"
    np.testing.assert_array_equal(log["q1"], samples[:, 1])


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(*[st.floats(allow_nan=False)] * 3), max_size=5))
def test_any_floats_survive(tmp_path_factory, rows):
    path = tmp_path_factory.mktemp("log") / "any.csv"
    with Recorder(path, COLUMNS) as recorder:
        for row in rows:
            recorder.write(*row)
    assert read_log(path).samples == rows


def test_nan_stands_for_a_value_that_was_not_measured(tmp_path):
    with Recorder(tmp_path / "gap.csv", COLUMNS) as recorder:
        recorder.write(0.0, float("nan"), 1.0)
    assert math.isnan(read_log(tmp_path / "gap.csv")["q1"][0])


def test_every_sample_is_on_the_disk_before_the_next(tmp_path):
    recorder = Recorder(tmp_path / "live.csv", COLUMNS)
    for i in range(5):
        recorder.write(i, i, i)
        assert len(read_log(recorder.path)) == i + 1
    recorder.close()


def test_an_interrupt_loses_nothing(tmp_path):
    def interrupted(recorder):
        with recorder:
            recorder.write(0.0, 1.0, 2.0)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted(Recorder(tmp_path / "cut.csv", COLUMNS))
    assert len(read_log(tmp_path / "cut.csv")) == 1


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full, the disk that is always full")
def test_a_full_disk_keeps_the_samples_in_memory_and_says_so(tmp_path):
    recorder = Recorder(tmp_path / "full.csv", COLUMNS)
    recorder.write(0.0, 1.0, 2.0)
    recorder._file.close()
    recorder._file = open("/dev/full", "w")  # noqa: SIM115 (the recorder closes it)
    with pytest.raises(LogError, match="No space left") as caught, recorder:
        recorder.write(3.0, 4.0, 5.0)
    assert caught.value.samples == [(0.0, 1.0, 2.0), (3.0, 4.0, 5.0)]
    assert len(read_log(write_log(recorder.log, tmp_path / "saved.csv"))) == 2


def test_a_log_is_never_overwritten(tmp_path):
    paths = []
    for i in range(3):
        with Recorder(tmp_path / "run.csv", COLUMNS) as recorder:
            recorder.write(i, i, i)
        paths.append(recorder.path.name)
    assert paths == ["run.csv", "run-2.csv", "run-3.csv"]
    assert read_log(tmp_path / "run.csv")["t"][0] == 0


def test_a_last_line_cut_short_is_left_out(tmp_path):
    with Recorder(tmp_path / "power.csv", COLUMNS) as recorder:
        recorder.write(0.0, 1.0, 2.0)
    with recorder.path.open("a") as file:
        file.write("0.02,3.1")
    assert len(read_log(recorder.path)) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,q1\n1,2\n", "not an omx log"),
        ("# omx log, format 1\n", "no heading"),
        ("# omx log, format 1\nt (s),q1 (deg)\n1.0,abc\n", "line 3: not numbers"),
        ("# omx log, format 1\nt (s),q1 (deg)\n1.0\n", "line 3: 1 values where the heading names 2"),
    ],
)
def test_damage_is_named_with_its_line(tmp_path, text, message):
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(LogError, match=message):
        read_log(tmp_path / "bad.csv")


def test_a_missing_folder_or_file_is_one_clear_error(tmp_path):
    with pytest.raises(LogError, match="cannot write"):
        Recorder(tmp_path / "nowhere" / "x.csv", COLUMNS)
    with pytest.raises(LogError, match="cannot read"):
        read_log(tmp_path / "absent.csv")


def test_a_sample_must_fill_the_columns(tmp_path):
    with Recorder(tmp_path / "x.csv", COLUMNS) as recorder, pytest.raises(BadInput, match="3 values"):
        recorder.write(1.0)
    with pytest.raises(BadInput, match="no column `q9`"):
        recorder.log["q9"]


def test_ticks_do_not_drift_and_none_is_left_out():
    clock, moments = SteppedClock(), []
    for i, t in enumerate(ticks(1.0, 50, clock)):
        moments.append(t)
        clock.sleep(0.1 if i == 10 else 0.003)  # one slow turn of the loop
    assert len(moments) == 51
    late = np.array(moments) - np.arange(51) / 50
    assert late.max() == pytest.approx(0.08)
    assert late[-1] == pytest.approx(0.0, abs=1e-12)


def test_ticks_keep_wall_time_unless_told_otherwise():
    moments = list(ticks(0.2, 50))
    assert len(moments) == 11
    assert moments[-1] >= 0.2


@pytest.mark.parametrize(("seconds", "rate"), [(-1, 50), (1, 0), (float("nan"), 50), (1, float("inf"))])
def test_ticks_need_a_time_and_a_rate(seconds, rate):
    with pytest.raises(BadInput, match="`seconds`"):
        list(ticks(seconds, rate))


# ---- the progress bar ----


class Screen(io.StringIO):
    """A terminal that shows what a person would see: a carriage return goes back and writes over."""

    def isatty(self):
        return True

    def lines(self):
        return [line.rsplit("\r", 1)[-1] for line in self.getvalue().split("\n")]


def test_a_progress_bar_draws_over_itself_and_ends_its_line():
    screen = Screen()
    bar = ProgressBar("log ", 10, screen)
    for i in range(101):
        bar(i / 100)
    assert screen.lines() == ["log [##########] 100 %", ""]
    drawn = screen.getvalue().split("\r")[1:]
    assert drawn == sorted(set(drawn), key=drawn.index)  # nothing is drawn twice
    assert all(line.count("#") + line.count(".") == 10 for line in drawn)


@pytest.mark.parametrize("share", [-1, 0, 0.5, 1, 2])
def test_a_progress_bar_never_leaves_its_frame(share):
    screen = Screen()
    ProgressBar("", 10, screen)(share)
    assert screen.lines()[0].startswith("[" + "#" * round(10 * min(max(share, 0), 1)))


def test_a_progress_bar_in_a_file_is_one_line():
    page = io.StringIO()
    bar = ProgressBar("", 10, page)
    for share in (0.0, 0.3, 1.0, 1.0):
        bar(share)
    assert page.getvalue() == "[##########] 100 %\n"


def test_a_screen_that_is_gone_does_not_stop_the_work():
    screen = Screen()
    bar = ProgressBar("", 10, screen)
    screen.close()
    bar(0.5)
    bar(1.0)
