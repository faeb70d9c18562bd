"""The generated modules belong together; if not, the reader is told which chapter to run."""

from types import SimpleNamespace

import pytest

from omx.generated import fk, ik, jacobian
from omx.kinematics import stale, warn_if_stale


def test_what_is_checked_in_belongs_together():
    assert stale() == []
    warn_if_stale()  # warnings are errors nowhere, so be sure that there is none


def longer_hand(*arguments):
    """The forward kinematics of an arm whose last DH row was edited: 30 mm longer."""
    *q, L1, L2, L3, L4, delta = arguments
    return fk.pose(*q, L1, L2, L3, L4 + 30, delta)


def test_an_edited_row_is_noticed_in_both():
    assert stale(SimpleNamespace(PARAMETERS=fk.PARAMETERS, pose=longer_hand)) == ["04", "05"]


def test_an_edited_length_is_not_a_reason():
    assert stale(SimpleNamespace(PARAMETERS={**fk.PARAMETERS, "L2": 150.5}, pose=fk.pose)) == []


def test_another_parameter_is_noticed():
    def pose(*arguments):
        return fk.pose(*arguments[:-1])

    assert stale(SimpleNamespace(PARAMETERS={**fk.PARAMETERS, "a1": 12.0}, pose=pose)) == ["04", "05"]


def test_only_the_chapter_that_is_behind_is_named():
    old = SimpleNamespace(jacobian=lambda *a: tuple(tuple(2 * x for x in row) for row in jacobian.jacobian(*a)))
    assert stale(fk, ik, old) == ["05"]


def test_the_warning_names_the_chapters(monkeypatch):
    monkeypatch.setattr("omx.kinematics.stale", lambda: ["04", "05"])
    with pytest.warns(UserWarning, match="04 and 05"):
        warn_if_stale()
