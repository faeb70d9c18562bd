"""Our fastest timing beside TOPP-RA's on the same paths, as JSON: `python -m tests.helpers.toppra_timing [PATHS]`.

Runs with the Python of the environment `peer-toppra`. Both get the same places of the path, the same limits, and the
same promise: each limit holds at both ends of every step.
"""

import json
import logging
import sys
import warnings

import numpy as np
from toppra import algorithm, constraint
from toppra.interpolator import AbstractGeometricPath

import omx
from omx.motion import Allowed, Path, fastest, in_joints, motor_torques, rounded, spline_path


class Given(AbstractGeometricPath):
    """One of our paths, which TOPP-RA asks about nothing but its own places."""

    def __init__(self, path):
        self.path = path

    def __call__(self, places, order=0):
        i = np.searchsorted(self.path.s, np.atleast_1d(places))
        found = (self.path.q, self.path.dq, self.path.ddq)[order][i]
        return found if np.ndim(places) else found[0]

    dof = property(lambda self: 4)
    path_interval = property(lambda self: self.path.s[[0, -1]])
    waypoints = property(lambda self: (self.path.s, self.path.q))


def theirs(path, allowed) -> tuple[np.ndarray, float]:
    """ds/dt (N,) at the places of the path, and the seconds that follow from it."""
    both = [
        np.column_stack([-np.array(limit), limit]) for limit in (allowed.speed, allowed.acceleration, allowed.torque)
    ]
    how = constraint.DiscretizationType.Interpolation

    def torques(q, qd, qdd):
        return motor_torques(q, qd, qdd, allowed.payload_g)

    limits = [
        constraint.JointVelocityConstraint(both[0]),
        constraint.JointAccelerationConstraint(both[1], discretization_scheme=how),
        constraint.JointTorqueConstraint(torques, both[2], np.zeros(4), discretization_scheme=how),
    ]
    timing = algorithm.TOPPRA(limits, Given(path), gridpoints=path.s, solver_wrapper="seidel")
    _, speed, _ = timing.compute_parameterization(0.0, 0.0)
    return speed, float(np.sum(2 * np.diff(path.s) / (speed[:-1] + speed[1:])))


def shortened(path) -> Path:
    """The same path with s from 0 to 3: TOPP-RA finds ways of hundreds of mm badly conditioned."""
    unit = path.s[-1] / 3
    return Path(path.s / unit, path.q, path.dq * unit, path.ddq * unit**2)


def paths(count: int):
    """Splines through random configurations, and rounded ways of the tool; each with limits of its own."""
    random = np.random.default_rng(18)
    while count:
        points = random.uniform(*np.array(omx.LIMITS).T * 0.7, (random.integers(2, 7), 4))
        path = spline_path(points, samples=int(random.integers(50, 400)))
        if random.uniform() < 0.4:
            corners = random.uniform((140, -120, 80, -0.5), (230, 120, 250, 0.5), (4, 4))
            try:
                path = shortened(in_joints(rounded(corners, random.uniform(2, 20), 200), omx.HOME))
            except omx.OmxError:  # a random way may leave the reach
                continue
        most = np.abs(motor_torques(path.q, payload_g=100)).max(axis=0) + 0.02
        allowed = Allowed(random.uniform(0.5, 4, 4), random.uniform(2, 30, 4), most + random.uniform(0.02, 1, 4), 100)
        yield path, allowed
        count -= 1


def main(count: int) -> dict:
    """The worst differences, relative: of the seconds, and of the speeds along the path."""
    seconds, speeds, longest = [], [], 0.0
    for path, allowed in paths(count):
        speed, duration = theirs(path, allowed)
        ours = fastest(path, allowed)
        along = np.linalg.norm(ours.qd, axis=1) / np.linalg.norm(path.dq, axis=1)
        seconds.append(ours.seconds / duration - 1)
        speeds.append(np.abs(along - speed).max() / speed.max())
        longest = max(longest, ours.seconds)
    return {"paths": count, "slower": max(seconds), "faster": -min(seconds), "speeds": max(speeds), "longest": longest}


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    logging.disable(logging.WARNING)
    print(json.dumps(main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)))
