"""How the cost of forward kinematics grows with the joints: planar arms of n equal links, 400 mm long in all."""

import numpy as np

import omx
from tests.bench.peers.contest import agreed
from tests.bench.sheet import Panel, Section, Size, Table, times
from tests.bench.timing import Contender, laps, nanoseconds, ratio

LENGTH_MM, ROWS, CLOSED = 400.0, 1000, "closed form, NumPy"
ONE, MANY, PIN = "Chain.fk, one", f"Chain.fk, {ROWS:,} rows, each", "pinocchio, forwardKinematics"

PROSE = f"""`omx.Chain` multiplies one 4x4 matrix for each joint, so the cost grows about in proportion to the joints:
by the power 1. Less means that a fixed part of a call still counts, more that the batch of {ROWS:,} rows no longer fits
the cache: the chain keeps all frames. pinocchio leaves its result in C++ memory. The closed form, a sum of
cosines and sines of running sums, knows that the arm is planar; the chain does not."""


def measure(size: Size) -> Section:
    section = Section("Growth with the joints: planar arms", PROSE)
    curves, rows = {}, []
    for n in size.joints:
        contenders = entered(n)
        times_of = laps(contenders, 75, size.seconds / 4)
        for contender in contenders:
            curves.setdefault(contender.name, []).append((n, nanoseconds(times_of, contender)))
        rows.append((str(n), *(times(ratio(times_of, c, contenders[0])) for c in contenders)))
    if PIN not in curves:
        section.left_out.append("pinocchio: it is not installed here")
    title = "Time of one configuration: how many times that of Chain.fk, one"
    section.tables.append(Table(title, ("joints", *curves), rows))
    lines = {name: [(n, ns * 1e-3) for n, ns in points] for name, points in curves.items()}
    section.panels.append(Panel("Growth with the joints", "joints of a planar arm", "time of one (us)", lines, {}))
    growth = [(name, f"{_exponent(points):.2f}") for name, points in curves.items()]
    title = f"Growth: the power of the joints by which time grows, from {size.joints[len(size.joints) // 2]} joints on"
    section.tables.append(Table(title, ("", "power"), growth))
    return section


def entered(n: int) -> list[Contender]:
    """The contenders for an arm of n joints, once they agree."""
    link = LENGTH_MM / n
    chain = omx.Chain([omx.DHRow(0.0, 0.0, link, 0.0)] * n)
    q = np.random.default_rng(n).uniform(-1.0, 1.0, (ROWS, n))

    def closed(angles):
        heading = np.cumsum(angles, axis=-1)
        return link * np.cos(heading).sum(axis=-1), link * np.sin(heading).sum(axis=-1)

    agreed(abs(chain.fk(q)[:, :2, 3].T - closed(q)))
    return [
        Contender(ONE, lambda: chain.fk(q[0])),
        Contender(MANY, lambda: chain.fk(q), count=ROWS),
        Contender(f"{CLOSED}, {ROWS:,} rows, each", lambda: closed(q), count=ROWS),
        *_pinocchio(n, link, q[0], chain),
    ]


def _pinocchio(n, link, q, chain) -> list[Contender]:
    try:
        import pinocchio as pin
    except ImportError:
        return []
    from tests.helpers.oracles import pinocchio_arm

    _, model, data, tool = pinocchio_arm([(0.0, 0.0, link, 0.0)] * n)
    pin.framesForwardKinematics(model, data, q)
    agreed(abs(data.oMf[tool].homogeneous - chain.fk(q)))
    return [Contender(PIN, lambda: pin.forwardKinematics(model, data, q))]


def _exponent(points) -> float:
    """From the second half of the arms: there the fixed part of a call counts least."""
    (n, first), (m, last) = points[len(points) // 2], points[-1]
    return float(np.log(last / first) / np.log(m / n))
