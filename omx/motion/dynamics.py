"""What a motion asks of the motors: the weight of the links, and their inertia.

The links are points with their masses, each at its centre of mass. What turns inside motors and gears, and friction,
are left out: no sheet gives them.
"""

import numpy as np

from ..arm import FOREARM, GRAVITY, UPPER_ARM, WRIST
from ..arrays import as_number, as_rows
from ..geometry import MAKER
from ..kinematics import JOINT_ANGLES

#: In the arm's plane a vector is a complex number, forward + 1j * up (mm): the links, and the centre of mass of each.
LINKS = np.array([MAKER.L2 * np.exp(1j * (np.pi / 2 - MAKER.delta)), MAKER.L3, MAKER.L4])
CENTRES = np.array([complex(*centre) for _, centre in (UPPER_ARM, FOREARM, WRIST)])
MASSES = np.array([mass for mass, _ in (UPPER_ARM, FOREARM, WRIST)])


def motor_torques(q, qd=(0.0,) * 4, qdd=(0.0,) * 4, payload_g: float = 0.0) -> np.ndarray:
    """The torques (..., 4) in Nm by which the motors move the arm so, or hold it where `qd` and `qdd` are 0.

    `q`, `qd`, `qdd`: (..., 4) in rad, rad/s, rad/s^2. `payload_g` (g) is at the tool. A link that pitches down is
    multiplied by exp(-1j angle): velocities and accelerations are the derivatives of that. The torque of a joint is
    what all masses beyond it ask for: each its force, across its lever. Raises `BadInput`.
    """
    rows = (
        as_rows(q, "q", 4, JOINT_ANGLES),
        as_rows(qd, "qd", 4, "joint velocities in rad/s"),
        as_rows(qdd, "qdd", 4, "joint accelerations in rad/s^2"),
    )
    masses = np.append(MASSES, as_number(payload_g, "payload_g", "a mass of 0 g or more", 0.0) / 1000)
    q, qd, qdd = np.broadcast_arrays(*rows)
    pitch, rate, rise = (np.cumsum(part[..., 1:], axis=-1) for part in (q, qd, qdd))
    moved = np.exp(-1j * pitch) * np.stack([np.ones_like(rate), -1j * rate, -1j * rise - rate**2])
    ends = np.cumsum(LINKS * moved, axis=-1)
    joints = ends - LINKS * moved
    place, velocity, acceleration = np.concatenate([joints + CENTRES * moved, ends[..., -1:]], axis=-1)
    spin, spun = qd[..., :1], qdd[..., :1]
    aside = masses * (place.real * spun + 2 * velocity.real * spin)
    force = masses * (acceleration - place.real * spin**2 + 1j * 1000 * GRAVITY)  # kg mm/s^2: mN
    torques = [(aside * place.real).sum(axis=-1)]
    for joint in range(3):
        levers = place[..., joint:] - joints[0, ..., joint, None]
        torques.append((levers * force[..., joint:].conj()).imag.sum(axis=-1))
    return np.stack(torques, axis=-1) / 1e6
