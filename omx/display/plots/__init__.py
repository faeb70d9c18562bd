"""The book's flat figures, one call each: arms, curves, maps, clouds of points.

Every function returns a `Picture`: a PNG in a notebook, with an alt text that tells in words and numbers what the
drawing shows. Lengths in mm (or the unit given), angles in rad. Colours are those of Okabe and Ito.
"""

from .arms import planar, side_view
from .charts import curves, heat_map
from .picture import Picture
from .places import cloud, plane, plane_map

__all__ = ["Picture", "cloud", "curves", "heat_map", "planar", "plane", "plane_map", "side_view"]
