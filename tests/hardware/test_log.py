"""Logs: what is written is read back to the last bit, and nothing that was sampled is lost."""

import csv
import io
import math
import os

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import omx
from omx.errors import BadInput, LogError
from omx.hardware.clock import SteppedClock, ticks
from omx.hardware.log import Recorder, read_log, write_log

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
    with pytest.raises(BadInput, match=r"`seconds`|`rate`"):
        list(ticks(seconds, rate))


# ---- what people write into it ----

words = st.text(st.characters(codec="utf-8"), max_size=30)


@settings(max_examples=200, deadline=None)
@given(words, words)
@example("Bob\n2nd", "# geometry: mine: L1=1.0")
@example("Bob\n# geometry: mine: L1=1.0, L2=2.0, L3=3.0, L4=4.0, delta=0.0", "a\n1,2,3\n")
@example('=HYPERLINK("http://x")', "x,=1+1;=2+2\t=3+3")
@example('"quoted"', ' "\\ud83d" ')
def test_any_note_comes_back_and_is_no_other_line(tmp_path_factory, first, second):
    path = tmp_path_factory.mktemp("log") / "any.csv"
    with Recorder(path, COLUMNS, omx.MAKER, student=first, remark=second) as recorder:
        recorder.write(1, 2, 3)
    log = read_log(path)
    assert log.notes == {"student": first, "remark": second}
    assert (log.geometry, log.units, log.samples) == (omx.MAKER, COLUMNS, [(1.0, 2.0, 3.0)])
    for separator in ",;\t":  # whatever a spreadsheet splits at
        for row in csv.reader(io.StringIO(path.read_text(encoding="utf-8"), newline="\n"), delimiter=separator):
            assert not any(cell.lstrip().startswith(("=", "@", "+")) for cell in row)


@pytest.mark.parametrize("name", ["q1, measured", 'the "true" q1', "x (tool)", "x; y", "Winkel q1"])
def test_odd_column_names_come_back(tmp_path, name):
    columns = {"t": "s", name: "deg"}
    with Recorder(tmp_path / "odd.csv", columns) as recorder:
        recorder.write(0.0, 1.5)
    assert read_log(tmp_path / "odd.csv").units == columns


@pytest.mark.parametrize("columns", [{"": "s"}, {"=1+1": "s"}, {"#t": "s"}, {"t\nx": "s"}, {"t": "s\n"}, {"t": "(s)"}])
def test_names_that_would_not_come_back_are_refused(tmp_path, columns):
    with pytest.raises(BadInput, match="column"):
        Recorder(tmp_path / "x.csv", columns)
    for note in ("geometry", "a: b", "a\nb", "=a"):
        with pytest.raises(BadInput, match="note"):
            Recorder(tmp_path / "x.csv", COLUMNS, **{note: "text"})
    assert not list(tmp_path.iterdir())


def test_a_spreadsheet_may_save_it_again(tmp_path):
    path = tmp_path / "run.csv"
    with Recorder(path, COLUMNS, omx.MAKER, student="Ann, Bob", group="7") as recorder:
        recorder.write(0.5, -1.25, 3.0)
    log = read_log(path)
    lines = path.read_text(encoding="utf-8").splitlines()
    padded = [line + ",," if line.startswith(("#", '"#')) else line for line in lines]
    path.write_bytes(b"\xef\xbb\xbf" + "\r\n".join([*padded, ""]).encode())
    assert read_log(path) == log


@pytest.mark.parametrize(
    ("line", "text", "message"),
    [
        (2, b"# geometry: mine: L1=77.0, L2=long", "not a geometry"),
        (2, b"# geometry: mine", "not a geometry"),
        (3, b"# student: B\xf6b", "UTF-8"),
        (3, b"# geometry: mine: L1=1.0", "a second `geometry`"),
        (4, b"t (s),t (s),q1 (deg)", "two called 't'"),
        (6, b"0.1,# note: x,3", "not numbers"),
        (6, b"# student: again", "not numbers"),
        (6, b"1,2", "2 values"),
    ],
)
def test_each_damaged_line_is_named(tmp_path, line, text, message):
    path = tmp_path / "bad.csv"
    with Recorder(path, COLUMNS, student="Ann") as recorder:
        for i in range(3):
            recorder.write(i, i, i)
    lines = path.read_bytes().split(b"\n")
    lines[line - 1] = text
    path.write_bytes(b"\n".join(lines))
    with pytest.raises(LogError, match=f"line {line}: .*{message}"):
        read_log(path)


@pytest.mark.parametrize("name", ["x" * 300 + ".csv", "a\0b.csv"])
def test_a_name_that_no_file_can_have_is_one_clear_error(tmp_path, name):
    with pytest.raises(LogError, match="cannot write"):
        Recorder(tmp_path / name, COLUMNS)
    with pytest.raises(LogError, match="cannot read"):
        read_log(tmp_path / name)


@pytest.mark.skipif(os.name == "nt", reason="links need a privilege there")
def test_a_link_to_nowhere_counts_as_taken(tmp_path):
    (tmp_path / "run.csv").symlink_to(tmp_path / "gone.csv")
    with Recorder(tmp_path / "run.csv", COLUMNS) as recorder:
        assert recorder.path.name == "run-2.csv"


def test_a_sample_is_numbers(tmp_path):
    with Recorder(tmp_path / "x.csv", COLUMNS) as recorder, pytest.raises(BadInput, match="numbers"):
        recorder.write("one", 2, 3)
