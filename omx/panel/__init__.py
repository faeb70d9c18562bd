"""Sliders beside the 3-D arm: joint angles in degrees, or the tool's pose with its four IK branches."""

from .joint import JointPanel
from .pose import PosePanel
from .row import RowPanel

__all__ = ["JointPanel", "PosePanel", "RowPanel"]
