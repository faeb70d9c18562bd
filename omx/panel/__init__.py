"""Sliders beside the 3-D arm: joint angles, the tool's pose with its four IK branches, a DH row, or a robot."""

from .joint import JointPanel
from .pose import PosePanel
from .robot import RobotPanel
from .row import RowPanel

__all__ = ["JointPanel", "PosePanel", "RobotPanel", "RowPanel"]
