"""What a function asks of NumPy, written down: the notes, carried out, give what the function gives."""

import numpy as np
import pytest

import omx
from omx.analysis.recorded import recorded
from omx.arrays import of_rows
from omx.generated import fk, ik

Q = np.random.default_rng(0).uniform(-2.0, 2.0, (50, 4))
POSES = np.vstack([omx.pose(Q), [[900.0, 0.0, 100.0, 0.3], [0.0, 0.0, 300.0, 9.0]]])


def carried_out(recording, rows):
    """What the statements give, column by column, in the order of the results."""
    lines, constants, results = recording
    names = vars(np) | {f"x{j}": column for j, column in enumerate(rows.T)} | {"p": constants}
    exec("\n".join(lines), names)
    return [np.broadcast_to(eval(name, names), len(rows)) for part in results for name in part]


@pytest.mark.parametrize(
    ("function", "rows"),
    [
        *((function, Q) for function in (omx.pose, omx.fk, omx.frames, omx.jacobian)),
        (omx.ik_batch, POSES),
        (lambda rows: of_rows(ik.branches_batch)(rows, *omx.MAKER.values), POSES),
    ],
)
def test_the_notes_carried_out_are_the_function(function, rows):
    expected = function(rows)
    parts = expected if isinstance(expected, tuple) else (expected,)
    columns = np.concatenate([part.reshape(len(rows), -1).T for part in parts])
    for one, other in zip(carried_out(recorded(function, 4), rows), columns, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-6 if rows is POSES else 1e-12 * 400)


def test_a_statement_is_one_call_and_a_constant_has_one_name():
    def function(rows):
        return np.where(rows[..., 0] < 0.5, 0.5 * rows[..., 1] ** 2, -rows[..., -1] + 0.0 - -0.0)

    assert recorded(function, 3) == (
        ("v0 = less(x0, p[0])", "v1 = power(x1, 2)", "v2 = multiply(p[0], v1)", "v3 = negative(x2)",
         "v4 = add(v3, p[1])", "v5 = subtract(v4, p[2])", "v6 = where(v0, v2, v5)"),
        (0.5, 0.0, -0.0),
        (("v6",),),
    )  # fmt: skip


def test_other_lengths_leave_the_statements_as_they_are():
    short, long = (
        recorded(lambda rows, L=L: of_rows(fk.transform_batch)(rows, *L), 4) for L in ((1.0,) * 5, (9.0,) * 5)
    )
    assert short[0] == long[0]
    assert 9.0 in long[1]


@pytest.mark.parametrize(
    ("function", "error", "told"),
    [
        (lambda rows: -rows[..., 0] if rows[..., 0] < 0 else rows[..., 0], omx.BadInput, "let it use `where`"),
        (lambda rows: np.clip(rows[..., 0], -0.5, 0.5), omx.BadInput, "`numpy.clip` like this"),
        (lambda rows: np.round(rows[..., 0], 2), omx.BadInput, "`numpy.round` like this"),
        (lambda rows: np.sin(rows[..., 0], dtype=np.float32), omx.BadInput, "`numpy.sin` like this"),
        (lambda rows: np.add.reduce(rows[..., 0]), omx.BadInput, "`numpy.add` like this"),
        (lambda rows: rows[..., 0] * np.ones(4), TypeError, "0-dimensional"),
        (lambda rows: 2 * rows, TypeError, "unsupported operand"),
        (lambda rows: np.sum(rows, axis=-1), TypeError, "does not support ufuncs"),
    ],
)
def test_what_cannot_be_written_down_is_refused(function, error, told):
    with pytest.raises(error, match=told):
        recorded(function, 4)
