"""Lines in space as a DH table: the same transforms, whatever the lines; a table that was there comes back."""

import os
from math import pi

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import omx
from omx.errors import BadInput
from omx.exchange import from_axes
from tests.helpers import oracles
from tests.helpers.urdf_arms import ARMS, transform

ANGLE, LENGTH = st.floats(-3, 3), st.floats(-300, 300)
TWIST = st.sampled_from([0.0, pi / 2, -pi / 2, pi]) | st.floats(-3.0, 3.0) | st.floats(-12, -1).map(lambda e: 10.0**e)
ROW = st.tuples(ANGLE, LENGTH | st.just(0.0), LENGTH | st.just(0.0), TWIST, st.booleans())
FRAME = st.builds(transform, st.tuples(LENGTH, LENGTH, LENGTH), st.tuples(ANGLE, st.sampled_from([0, pi / 2]), ANGLE))


def axes_of(chain):
    """(directions, points, tool, prismatic) of a chain at zero."""
    frames = chain.frames(np.zeros(len(chain)))
    return frames[:-1, :3, 2], frames[:-1, :3, 3], frames[-1], [row.prismatic for row in chain.rows]


@settings(max_examples=int(os.environ.get("OMX_FUZZ", 150)), deadline=None)
@given(st.lists(ROW, min_size=1, max_size=7), FRAME, FRAME, st.integers(0, 10**6))
def test_any_axes_have_a_table(rows, base, tool, seed):
    chain = omx.Chain(rows, base=base, tool=tool)
    directions, points, T, slides = axes_of(chain)
    random = np.random.default_rng(seed)
    slid = points + random.uniform(-500, 500, (len(rows), 1)) * directions  # any point of an axis will do
    try:
        found = from_axes(directions * random.uniform(0.5, 2, (len(rows), 1)), slid, T, slides)
    except BadInput:
        assume(any(0 < abs(np.sin(row[3])) < 0.1 for row in rows))  # nearly parallel: better none than a wrong one
        return
    q = random.uniform(-3, 3, (20, len(rows)))
    near = 1e-9 + 1e-14 * max(abs(row.d) for row in found.rows)  # a frame a kilometre away has few digits left
    np.testing.assert_allclose(found.fk(q), chain.fk(q), atol=near)
    np.testing.assert_allclose(found.jacobian(q), chain.jacobian(q), atol=near)


@pytest.mark.parametrize("name", ["course", "maker"])
def test_the_arms_own_table_comes_back(name):
    chain = ARMS[name][1]
    found = from_axes(*axes_of(chain))
    assert (found.base, found.tool) == (None, None)
    for ours, back in zip(chain.rows, found.rows, strict=True):
        np.testing.assert_allclose(back.at(0.0), ours.at(0.0), atol=1e-12)


def test_axes_that_are_nearly_parallel_are_refused_or_taken_as_parallel():
    tilt = 3.7e-6  # as 1.5708 for a quarter of a turn makes it
    tool = transform((250, 0, 77), (0, 0, 0))
    axes = {"directions": [(0, 1, 0), (tilt, 1, 0)], "points": [(0, 0, 77), (130, 0, 77)], "tool": tool}
    with pytest.raises(BadInput, match=r"joints 1 and 2 are 3.7e-06 rad from parallel.*3.51e\+04 m away.*`tolerance`"):
        from_axes(**axes)
    taken = from_axes(**axes, tolerance=1e-5)
    assert [row.alpha for row in taken.rows[:1]] == [0.0]
    exact = from_axes(**axes | {"directions": [(0, 1, 0), (0, 1, 0)]})
    np.testing.assert_allclose(taken.fk([0.4, -0.7]), exact.fk([0.4, -0.7]), atol=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"directions": [(0, 0, 1)]}, "`points` must be as many"),
        ({"directions": [(0, 0, 0), (0, 1, 0)]}, "a direction not 0"),
        ({"directions": "up"}, "`directions` must be"),
        ({"directions": (0, 0, 1)}, "`directions` must be"),
        ({"points": [(0, 0, np.nan)] * 2}, "`points`.*finite"),
        ({"tool": np.eye(3)}, "`tool` must be a transform"),
        ({"tool": None}, "with a `tool`"),
        ({"prismatic": [True]}, "`prismatic` must be 2 times True or False"),
        ({"prismatic": [2, 0]}, "`prismatic`"),
        ({"prismatic": 5}, "`prismatic`"),
        ({"tolerance": -1}, "`tolerance` must be an angle"),
        ({"limits": [(0, 1)]}, "`limits` must be 2 pairs"),
    ],
)
def test_what_is_no_axis_is_refused_by_name(change, message):
    good = {"directions": [(0, 0, 1), (0, 1, 0)], "points": np.zeros((2, 3)), "tool": oracles.shift(5, 6)}
    from_axes(**good)
    with pytest.raises(BadInput, match=message):
        from_axes(**good | change)
