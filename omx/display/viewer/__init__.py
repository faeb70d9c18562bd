"""The arm in 3-D: a MeshCat scene in the notebook's output cell, or in a page without a kernel."""

from ..palette import PALETTE
from .dh_row_view import RowView
from .environment import Camera
from .view import View

__all__ = ["PALETTE", "Camera", "RowView", "View"]
