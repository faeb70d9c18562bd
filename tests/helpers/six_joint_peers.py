"""Other people's answers to the same poses, from a peer's own Python: `-m tests.helpers.six_joint_peers PEER FILE`.

FILE holds, as .npz, a table `rows` (n, 5): theta, d, a, alpha, slides?, in mm and rad, and `poses` (N, 4, 4). The
answers come back in FILE.out.npz as `q` (N, most answers, 6), NaN where there are fewer. Lengths go to the peers in
units of 100 mm, for some of them have tolerances that are meant for metres.
"""

import sys

import numpy as np

UNIT = 100.0


def eaik(rows):
    from eaik.IK_DH import DhRobot

    robot = DhRobot(rows[:, 3], rows[:, 2], rows[:, 1])

    def solve(T):
        found = robot.IK(T)  # also what comes nearest, where there is no answer
        return [q for q, nearest in zip(found.Q, found.is_LS, strict=True) if not nearest]

    solve.bare = robot.IK  # what is timed
    return solve


def ssik(rows):
    from ssik import Manipulator

    arm = Manipulator.from_dh(rows[:, 3], rows[:, 2], rows[:, 1])
    return lambda T: [solution.q for solution in arm.solve(T, respect_limits=False, enumerate_windings=False)]


def toolbox(rows):
    from roboticstoolbox import DHRobot, PrismaticDH, RevoluteDH

    links = [
        PrismaticDH(theta=theta, a=a, alpha=alpha, offset=d, qlim=[-99, 99])
        if slides
        else RevoluteDH(d=d, a=a, alpha=alpha, offset=theta)
        for theta, d, a, alpha, slides in rows
    ]
    solver = DHRobot(links).analytic_ik()
    return lambda T: solver.solve(T, joint_limits=False).q


PEERS = {"eaik": eaik, "ssik": ssik, "toolbox": toolbox}


def main(name, file):
    given = np.load(file)
    rows, poses = given["rows"].copy(), given["poses"].copy()
    rows[:, 1:3] /= UNIT
    poses[:, :3, 3] /= UNIT
    solve = PEERS[name](rows)
    answers = [np.array([np.asarray(q, float) for q in solve(T)]).reshape(-1, len(rows)) for T in poses]
    q = np.full((len(poses), max(map(len, answers)), len(rows)), np.nan)
    for into, found in zip(q, answers, strict=True):
        into[: len(found)] = found
    q[..., rows[:, 4] > 0] *= UNIT
    np.savez(f"{file}.out.npz", q=q)


if __name__ == "__main__":
    main(*sys.argv[1:])
