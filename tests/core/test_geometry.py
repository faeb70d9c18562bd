"""Geometry: named lengths that do not change, and the two descriptions of the arm side by side."""

import copy
import subprocess
import sys
from math import asin, degrees, dist, hypot, pi

import numpy as np
import pytest

import omx
from omx import COURSE, MAKER, BadInput, Geometry
from tests.helpers import oracles

LENGTHS = dict(zip(("L1", "L2", "L3", "L4", "delta"), oracles.COURSE, strict=True))


def test_course_has_the_lengths_of_the_lab():
    assert COURSE.values == oracles.COURSE
    assert (COURSE.L1, COURSE.L2, COURSE.L3, COURSE.L4) == (77, 130, 124, 126)
    assert degrees(COURSE.delta) == pytest.approx(10.6387, abs=5e-5)


def test_maker_has_the_dog_leg_of_the_urdf():
    assert (MAKER.L1, MAKER.L3, MAKER.L4) == (76.5, 124, 126)
    assert pytest.approx(130.2306, abs=5e-5) == MAKER.L2
    assert degrees(MAKER.delta) == pytest.approx(10.6197, abs=5e-5)
    up, forward = MAKER.L2 * np.cos(MAKER.delta), MAKER.L2 * np.sin(MAKER.delta)
    assert (up, forward) == pytest.approx((128, 24), abs=1e-12)


def test_the_two_models_are_a_quarter_of_a_millimetre_apart():
    """Besides the 0.5 mm of the shoulder's height; the arm repeats to 0.2 mm."""
    same_shoulder = MAKER.replace(L1=COURSE.L1)
    gaps = [dist(omx.pose(q)[:3], omx.pose(q, same_shoulder)[:3]) for q in (omx.ZERO, omx.HOME, (1, 0.5, -0.7, 0.3))]
    assert gaps == pytest.approx([0.235] * 3, abs=1e-3)
    assert dist(omx.pose(omx.ZERO)[:3], omx.pose(omx.ZERO, MAKER)[:3]) == pytest.approx(0.265, abs=1e-3)


def test_the_tip_at_zero():
    assert omx.pose(omx.ZERO) == pytest.approx((274, 0, 204.765, 0), abs=5e-4)
    assert omx.pose(omx.ZERO, MAKER) == pytest.approx((274, 0, 204.5, 0), abs=1e-12)


def test_home_is_level_legal_and_behind_the_shoulder():
    x, y, z, pitch = omx.pose(omx.HOME)
    assert (y, pitch) == pytest.approx((0, 0), abs=1e-15)
    assert x < 274
    assert z > COURSE.L1
    for q in (omx.HOME, omx.ZERO):
        assert not COURSE.chain.violations(q)


def test_limits_are_those_of_the_urdf():
    humble = ((-pi, pi), (-1.5, 1.5), (-1.5, 1.4), (-1.7, 1.97))
    assert humble == omx.LIMITS


def test_the_straight_arm_is_inside_the_limits():
    straight = COURSE.delta - pi / 2
    assert degrees(straight) == pytest.approx(-79.36, abs=5e-3)
    assert omx.LIMITS[2][0] < straight < omx.LIMITS[2][1]


def test_the_chain_carries_the_labs_table_and_the_limits():
    rows = [(row.theta, row.d, row.a, row.alpha) for row in COURSE.chain.rows]
    np.testing.assert_allclose(rows, oracles.table(*oracles.COURSE), atol=1e-15)
    assert COURSE.chain.limits == omx.LIMITS
    assert COURSE.chain is COURSE.chain


def test_a_geometry_does_not_change():
    geometry = COURSE.replace("mine", L2=140)
    with pytest.raises(AttributeError, match=r"\.replace\(L2=150\)"):
        geometry.L2 = 150
    with pytest.raises(AttributeError, match="L2"):
        del geometry.L2
    assert (geometry.name, geometry.L2, COURSE.L2) == ("mine", 140, 130)


def test_equal_lengths_are_equal_geometries():
    twin = Geometry("twin", **LENGTHS)
    assert twin == COURSE
    assert hash(twin) == hash(COURSE)
    assert twin != MAKER
    assert twin != "course"
    assert {COURSE: 1}[twin] == 1
    assert copy.deepcopy(MAKER) == MAKER


def test_replace_names_what_it_makes():
    assert COURSE.replace(L3=1).name == "course, changed"
    assert repr(COURSE.replace("mine", L1=1.5, delta=0)) == "Geometry('mine', L1=1.5, L2=130, L3=124, L4=126, delta=0)"


@pytest.mark.parametrize(
    ("lengths", "message"),
    [
        ({}, "must give L1, L2, L3, L4, delta; wrong or missing: L1, L2, L3, L4, delta"),
        ({**LENGTHS, "L9": 1}, "wrong or missing: L9"),
        ({**LENGTHS, "L2": "long"}, "`L2` must be a finite number .* got 'long'"),
        ({**LENGTHS, "L2": None}, "`L2` must be a finite number"),
        ({**LENGTHS, "delta": float("nan")}, "`delta` must be a finite number"),
        ({**LENGTHS, "L1": float("inf")}, "`L1` must be a finite number"),
        ({**LENGTHS, "L3": 1e160}, "`L3` must be a finite number"),
    ],
)
def test_a_wrong_length_is_named(lengths, message):
    with pytest.raises(BadInput, match=message):
        Geometry("mine", **lengths)


def test_replace_refuses_unknown_lengths():
    with pytest.raises(BadInput, match="wrong or missing: L5"):
        COURSE.replace(L5=1)


def test_the_dog_leg_in_two_ways():
    assert asin(24 / 130) != pytest.approx(MAKER.delta, abs=1e-5)
    assert hypot(128, 24) - 130 == pytest.approx(0.2306, abs=5e-5)


OTHER_TABLE = """
import importlib, omx, omx.geometry
from omx.generated import fk
del fk.PARAMETERS["delta"]
geometry = importlib.reload(omx.geometry)
assert (geometry.COURSE.L2, geometry.MAKER.L1) == (130, 76.5)
"""


def test_a_readers_table_without_the_dog_leg_does_not_stop_the_import():
    done = subprocess.run([sys.executable, "-c", OTHER_TABLE], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
