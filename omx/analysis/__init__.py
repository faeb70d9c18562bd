"""What an arm can reach and how exactly: workspace, accuracy and calibration, equivalence of DH tables, all answers
of generated inverses, large batches.

`omx.analysis.compiled` needs numba and is imported by name.
"""

from . import accuracy, workspace
from .equivalence import same_robot
from .inverse import Inverse, Solution

__all__ = ["Inverse", "Solution", "accuracy", "same_robot", "workspace"]
