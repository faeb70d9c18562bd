"""Files that other programs read, and what they are made of: robot descriptions (URDF), joint axes as DH tables."""

from . import urdf
from .axes import from_axes

__all__ = ["from_axes", "urdf"]
