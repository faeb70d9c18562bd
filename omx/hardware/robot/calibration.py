"""What one arm's calibration found, kept in one small file: add the offsets to the readings, use the lengths.

The file is for the arm, not in it: nothing is written to a servo. `Robot(port, calibration="arm-3.json")` reads it.
"""

import json
import math
import os
from pathlib import Path
from typing import NamedTuple

from ...arrays import as_rows, shown
from ...errors import BadInput
from ...generated.fk import PARAMETERS
from ...geometry import Geometry

FORMAT = "omx calibration, format 1"
#: The largest offset (rad) that a calibration may correct. More is a horn screwed on wrong, and is mended there.
MOST = math.radians(10.0)


class Calibration(NamedTuple):
    """The lengths of one arm, and the offsets (rad) to add to its four joint readings. `name`: where it comes from."""

    geometry: Geometry
    offsets: tuple[float, float, float, float]
    name: str = "calibration"

    def __str__(self) -> str:
        offsets = ", ".join(f"{math.degrees(offset):+.2f}" for offset in self.offsets)
        return f"{self.name}: offsets {offsets} deg, {self.geometry!r}"


def save_calibration(found, path="calibration.json") -> Path:
    """Write the `geometry` and the `offsets` (rad) of `found`, such as what `accuracy.calibrate` returns, to `path`.

    A file of that name is replaced: an arm has one calibration. Raises `BadInput`.
    """
    path = Path(path)
    geometry, offsets = found.geometry, _offsets(found.offsets, path.name)
    content = {
        "format": FORMAT,
        "geometry": {"name": geometry.name, **dict(zip(PARAMETERS, map(float, geometry.values), strict=True))},
        "offsets_rad": list(offsets),
    }
    try:
        path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise BadInput(f"cannot write {path.name}: {error.strerror}. Choose another folder or name.") from error
    return path


def as_calibration(given) -> Calibration:
    """`given` itself, with `geometry` and `offsets` like what `accuracy.calibrate` returns, or a file's name."""
    if isinstance(given, (str, os.PathLike)):
        return load_calibration(given)
    if not isinstance(getattr(given, "geometry", None), Geometry) or not hasattr(given, "offsets"):
        raise BadInput(f"`calibration` is what `calibrate` found, or a file's name; got {shown(given)}.")
    name = getattr(given, "name", Calibration._field_defaults["name"])
    return Calibration(given.geometry, _offsets(given.offsets, name), name)


def load_calibration(path) -> Calibration:
    """What `save_calibration` wrote; raises `BadInput` with what is wrong with the file."""
    path = Path(path)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if content["format"] != FORMAT:
            raise ValueError(f"its format is {content['format']!r}, not {FORMAT!r}")
        lengths = dict(content["geometry"])
        geometry = Geometry(lengths.pop("name"), **lengths)
        return Calibration(geometry, _offsets(content["offsets_rad"], path.name), path.name)
    except BadInput:
        raise
    except OSError as error:
        raise BadInput(f"cannot read {path.name}: {error.strerror}.") from error
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise BadInput(f"{path.name} is not a calibration that `save_calibration` wrote: {error}.") from error


def _offsets(values, name: str) -> tuple[float, float, float, float]:
    offsets = tuple(as_rows(values, "offsets", 4, "four joint offsets in rad").ravel().tolist())
    worst = max(range(4), key=lambda i: abs(offsets[i]))
    if len(offsets) != 4 or abs(offsets[worst]) > MOST:
        raise BadInput(
            f"{name}: {math.degrees(offsets[worst]):.1f} deg in joint {worst + 1} is no calibration, which is up to "
            f"{math.degrees(MOST):.0f} deg. Look at the horn and the homing offset: `python run.py doctor`."
        )
    return offsets
