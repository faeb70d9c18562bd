"""Sliders beside the 3-D arm: joint angles, the pose with its four IK branches, the hand of a six-joint arm with its
eight, a DH row, a robot, a robot taught.

And sliders under a figure that is computed where it is seen.
"""

from .branch_panels import HandPanel, PosePanel
from .dh_row_panel import RowPanel
from .joint_panel import JointPanel
from .live_figure import LiveFigure
from .robot_panel import RobotPanel
from .teach_panel import TeachPanel

__all__ = ["HandPanel", "JointPanel", "LiveFigure", "PosePanel", "RobotPanel", "RowPanel", "TeachPanel"]
