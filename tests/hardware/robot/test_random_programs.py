"""Programs in any order of commands, faults, stops and exits: no promise is broken. Thousands are run by hand.

`python -m tests.helpers.programs --programs 2000` is the long run; OMX_PROGRAMS sets a number here.
"""

import os

import pytest

from tests.helpers.programs import run

#: Of the first hundred programs those that together take every branch of `omx` that all of them take (3,153, by
#: coverage.py), and end every command in each way in which it ends in any of them (102).
#: Once a week, and with OMX_PROGRAMS=100, all of them run.
CHOSEN = (
    8, 12, 13, 15, 16, 19, 20, 21, 23, 24, 34, 39, 40, 43, 45, 48, 49, 57, 59, 63,
    64, 66, 68, 70, 71, 73, 74, 75, 76, 77, 79, 82, 84, 85, 86, 87, 88, 92, 94, 97,
)  # fmt: skip
PROGRAMS, PARTS = range(int(os.environ.get("OMX_PROGRAMS", "0"))) or CHOSEN, 4


@pytest.mark.parametrize("part", range(PARTS))
def test_no_program_breaks_a_promise(part):
    for number in PROGRAMS[part::PARTS]:
        run(2026, number, length=8)
