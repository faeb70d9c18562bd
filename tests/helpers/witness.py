"""What a virtual arm really does, at every step of its 2 ms grid: where its joints are, whatever its encoders say."""

import math

import numpy as np

import omx
from omx.collision import clearance
from omx.hardware.simulator.virtual_arm import STEP_S


class Witness:
    """Records the true joints of `arm` from now on: `q` (N, 4) in rad, a row for each step at which anything moved."""

    def __init__(self, arm):
        self.times, self.rows = [], []
        live = arm._live

        def seen(steps):
            self.times.append(arm.time)
            self.rows.append([joint.angle for joint in arm.joints[:4]])
            live(steps)

        arm._live = seen

    @property
    def q(self) -> np.ndarray:
        return np.array(self.rows)

    def top_speed(self, window_s: float = 0.1, slack_deg: float = 1.0) -> float:
        """The fastest that a joint turned over `window_s` (rad/s), less the tenths of a degree that an arm sags."""
        t, q = np.array(self.times), self.q
        later = np.searchsorted(t, t + window_s - STEP_S / 2)
        ok = later < len(t)
        turned = np.abs(q[later[ok]] - q[ok]).max(axis=1) - math.radians(slack_deg)
        return float((turned / (t[later[ok]] - t[ok])).max(initial=0.0))

    def lowest(self) -> float:
        """The smallest gap (mm) between the arm and the table, or between two of its parts; negative: they met."""
        return float(clearance(self.q).min()) if self.rows else math.inf

    def beyond(self, limits=omx.LIMITS) -> float:
        """How far (rad) a joint was outside its limits at most."""
        low, high = np.array(limits).T
        return float(np.maximum(low - self.q, self.q - high).max(initial=0.0))
