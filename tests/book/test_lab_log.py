"""The checker of students' logs finds nothing in a measured one, and says what was done to others."""

import dataclasses

import numpy as np
import pytest

from book.chapters import lab_log
from book.setup.paths import ROOT
from omx.hardware.log import read_log

SAMPLE = ROOT / "book" / "teach" / "sample-log.csv"


def changed(change):
    """The sample's columns, changed, as a log."""
    log = read_log(SAMPLE)
    columns = {name: log[name] for name in log.columns}
    change(columns)
    samples = [tuple(row) for row in np.column_stack(list(columns.values())).tolist()]
    units = {name: log.units.get(name, "deg") for name in columns}
    return dataclasses.replace(log, columns=tuple(columns), units=units, samples=samples)


def smooth(c):
    c["q2"] = np.linspace(-60, -20, len(c["t"]))


def commanded(shift):
    def add(c):
        for j in range(1, 5):
            c[f"c{j}"] = np.interp(c["t"] + shift, c["t"], c[f"q{j}"])

    return add


ODD = {
    "the time step is not even": lambda c: c.update(t=np.where(c["t"] > 1, c["t"] + 0.2, c["t"])),
    "time does not go on": lambda c: c.update(t=np.minimum(c["t"], 1.0)),
    "q2 is not in whole ticks": smooth,
    "no joint moves by 2 deg": lambda c: c.update({f"q{j}": 0 * c["t"] for j in range(1, 5)}),
    "v1 is not the speed of q1": lambda c: c.update(v1=c["v1"][::-1] * 0 + np.arange(len(c["t"])) % 2),
    "q2 leaves its limits": lambda c: c.update(q1=c["q2"], q2=c["q1"] * 3),
    "x, y, z are up to": lambda c: c.update(x=c["x"] + 5),
    "the measured angles are the commanded ones": commanded(0.0),
    "ms ahead of its command": commanded(-0.2),
    "it has no column q3": lambda c: c.pop("q3"),
}


@pytest.mark.parametrize("sentence", ODD)
def test_what_is_odd_about_a_log_is_said(sentence):
    assert sentence in "; ".join(lab_log.oddities(changed(ODD[sentence])))


def test_a_measured_log_has_nothing_odd_and_may_lag_behind_its_command(capsys):
    assert lab_log.main([str(SAMPLE)]) == 0
    assert "51 samples, 2.5 s; nothing is odd" in capsys.readouterr().out
    assert list(lab_log.oddities(changed(commanded(0.2)))) == []


def test_a_file_that_is_no_log_gets_a_sentence(tmp_path, capsys):
    (tmp_path / "bad.csv").write_text("hello")
    assert lab_log.main([str(tmp_path / "bad.csv"), str(tmp_path / "missing.csv")]) == 1
    assert len(capsys.readouterr().out.splitlines()) == 2
