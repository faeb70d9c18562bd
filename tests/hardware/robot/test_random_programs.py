"""A hundred programs in any order of commands, faults, stops and exits: no promise is broken. Thousands run by hand.

`python -m tests.helpers.programs --programs 2000` is the long run; OMX_PROGRAMS sets another number here.
"""

import os

import pytest

from tests.helpers.programs import run

PROGRAMS, PARTS = int(os.environ.get("OMX_PROGRAMS", "100")), 4


@pytest.mark.parametrize("part", range(PARTS))
def test_no_program_breaks_a_promise(part):
    for number in range(part, PROGRAMS, PARTS):
        run(2026, number, length=8)
