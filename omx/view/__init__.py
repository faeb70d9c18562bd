"""The arm in 3-D: a MeshCat scene in the notebook's output cell, or in a page without a kernel."""

from .annotate import PALETTE
from .row import RowView
from .stage import Camera
from .static import write_site_script
from .view import View

__all__ = ["PALETTE", "Camera", "RowView", "View", "write_site_script"]
