"""Sliders beside the 3-D arm: joint angles, the pose with its four IK branches, a DH row, a robot, a robot taught.

And sliders under a figure that is computed where it is seen.
"""

from .dh_row_panel import RowPanel
from .joint_panel import JointPanel
from .live_figure import LiveFigure
from .pose_panel import PosePanel
from .robot_panel import RobotPanel
from .teach_panel import TeachPanel

__all__ = ["JointPanel", "LiveFigure", "PosePanel", "RobotPanel", "RowPanel", "TeachPanel"]
