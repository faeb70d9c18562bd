"""What an arm can reach and how exactly: workspace, accuracy and calibration, equivalence of DH tables, large batches.

`omx.analysis.compiled` needs numba and is imported by name.
"""

from . import accuracy, workspace
from .equivalence import same_robot

__all__ = ["accuracy", "same_robot", "workspace"]
