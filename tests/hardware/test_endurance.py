"""The short version of tests/helpers/endurance.py: some rounds in stepped time, and a few seconds in real time."""

from omx.hardware.log import read_log
from omx.hardware.simulator import Clock, SteppedClock
from tests.helpers.endurance import endure


def test_rounds_of_moving_logging_and_dragging_end_where_they_began(tmp_path):
    found = endure(60.0, tmp_path / "a.csv", SteppedClock())
    assert found.carried == found.gripped == len(found.home) >= 4
    assert found.degrees < 50
    assert found.missed == 0
    assert len(read_log(tmp_path / "a.csv")) == found.taken
    assert found.drift < 0.1
    assert found.growth < 2e6
    assert max(found.late) < 0.02


def test_real_time_scaled_misses_no_sample(tmp_path):
    found = endure(20.0, tmp_path / "a.csv", Clock(3.0))
    assert (found.missed, len(read_log(tmp_path / "a.csv"))) == (0, found.taken)
    assert found.drift < 0.3
