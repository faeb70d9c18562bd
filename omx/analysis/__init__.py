"""What an arm can reach and how exactly: workspace, accuracy and calibration, equivalence of DH tables, all answers
of generated inverses, large batches.

`omx.analysis.compiled`, which is fast where numba is installed, and `recorded` are imported by name.
"""

from . import accuracy, workspace
from .equivalence import same_robot
from .inverse import Inverse, Solution

__all__ = ["Inverse", "Solution", "accuracy", "same_robot", "workspace"]
