"""The book's flat figures, one call each: arms, curves, maps, clouds of points.

Every function returns a `Picture`: a PNG in a notebook, with an alt text that tells in words and numbers what the
drawing shows. Lengths in mm (or the unit given), angles in rad. Colours are those of Okabe and Ito.
"""

import logging

# Before Matplotlib is imported: where it has no fonts listed yet, it would say so in the reader's first cell.
logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)

from .arms import planar, side_view  # noqa: E402
from .charts import cloud, curves, plane, plane_map  # noqa: E402
from .picture import Picture  # noqa: E402

__all__ = ["Picture", "cloud", "curves", "planar", "plane", "plane_map", "side_view"]
