"""jax: our generated formulas, compiled by XLA for float64 on the processor, arrays in and arrays out."""

import os
from math import tau
from types import FunctionType

import jax
import jax.numpy as jnp
import numpy as np

import omx
from omx import kinematics
from omx.generated import fk, ik
from tests.bench.contenders import Q
from tests.bench.peers.contest import Contest, agreed, configurations, our_ik, our_pose, threaded
from tests.bench.timing import Contender
from tests.helpers import oracles

jax.config.update("jax_enable_x64", True)
LENGTHS = omx.COURSE.values

#: As many as this process may run on: so many threads XLA takes.
PROCESSORS = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def wrap(x):
    """Angles into (-pi, pi]."""
    return x - tau * jnp.ceil(x / tau - 0.5)


def translated(function):
    """A generated batch function with jax's functions in place of NumPy's."""
    names = {"np": jnp, "sincos": lambda x: (jnp.sin(x), jnp.cos(x)), "wrap": wrap}
    return FunctionType(function.__code__, function.__globals__ | names, function.__name__)


@jax.jit
def pose(q):
    """(n, 4) -> (n, 4)."""
    return jnp.stack(translated(fk.pose_batch)(*q.T, *LENGTHS), axis=-1)


@jax.jit
def ik_batch(poses):
    """(n, 4) -> angles (4 branches, 4 joints, n), reachable and legal (4, n): `omx.ik_batch`, in the same order."""
    *angles, front, back = translated(ik.branches_batch)(*poses.T, *LENGTHS)
    within = [jnp.abs(D) <= 1.0 + kinematics.REACH_SLACK for D in (front, back)]
    reachable = jnp.stack([within[0], within[0], within[1], within[1]])
    q = jnp.stack([jnp.stack([jnp.broadcast_to(a, front.shape) for a in branch]) for branch in angles])
    low, high = jnp.array(omx.LIMITS).T[:, None, :, None]
    slack = kinematics.LIMIT_SLACK
    legal = reachable & ((q >= low - slack) & (q <= high + slack)).all(axis=1)
    return jnp.where(reachable[:, None], q, jnp.nan), reachable, legal


def forward_one(_) -> Contest:
    q = jnp.array([Q])
    gap = agreed(oracles.pose_gap(np.asarray(pose(q)), omx.pose([Q])))
    theirs = Contender("compiled, one row", lambda: pose(q).block_until_ready(), wall=True)
    return Contest([Contender("omx.pose", lambda: omx.pose(Q))], [theirs], gap)


def forward(count: int) -> Contest:
    q = configurations(count)
    rows = jnp.array(q)
    gap = agreed(oracles.pose_gap(np.asarray(pose(rows))[:10_000], omx.pose(q[:10_000])))
    theirs = Contender(threaded("compiled", PROCESSORS), lambda: pose(rows).block_until_ready(), count=count,
                       threads=PROCESSORS, wall=True)  # fmt: skip
    return Contest(our_pose(q, (PROCESSORS,)), [theirs], gap)


def inverse(count: int) -> Contest:
    poses = omx.pose(configurations(count))
    rows = jnp.array(poses)
    found, expected = [np.asarray(part) for part in ik_batch(rows)], omx.ik_batch(poses[:10_000])
    reachable = expected[1]
    assert (found[1].T[:10_000] == reachable).all()
    assert (found[2].T[:10_000] == expected[2]).mean() > 0.999  # a limit hit exactly may round to either side
    gap = agreed(oracles.angle_gap(found[0].transpose(2, 0, 1)[:10_000][reachable], expected[0][reachable]))
    theirs = Contender(threaded("compiled", PROCESSORS), lambda: jax.block_until_ready(ik_batch(rows)), count=count,
                       threads=PROCESSORS, wall=True)  # fmt: skip
    return Contest(our_ik(poses, (PROCESSORS,)), [theirs], gap)


WORK = {"FK, one": forward_one, "FK, batch": forward, "IK, batch": inverse}
