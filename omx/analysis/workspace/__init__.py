"""Where the arm's tip can go: exactly, from circular arcs; by sampling, for any chain; and how freely, as maps."""

from ...collision import clear, clearance
from .arcs import Arc, critical_arcs
from .maps import BranchMap, PitchMap, branch_map, pitch_map
from .reach import reaches
from .sampling import Counts, count_plane, count_space, sample_joints, tips
from .section import ArmSection, Grid, Section, section

__all__ = [
    "Arc", "ArmSection", "BranchMap", "Counts", "Grid", "PitchMap", "Section", "branch_map", "clear", "clearance",
    "count_plane", "count_space", "critical_arcs", "pitch_map", "reaches", "sample_joints", "section", "tips",
]  # fmt: skip
