"""The arm in 3-D: a MeshCat scene in the notebook's output cell, or in a page without a kernel."""

from ..palette import PALETTE
from .camera_and_light import Camera
from .dh_row_view import RowView
from .view import View

__all__ = ["PALETTE", "Camera", "RowView", "View"]
