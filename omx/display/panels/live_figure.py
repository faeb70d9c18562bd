"""`LiveFigure`: a figure under sliders, computed where it is seen, by the generated JavaScript formulas.

It needs no Python while it moves: a page, a deck and a notebook show the same figure by the same scripts. What each one
shows is in `figures.js`, how it is drawn in `chart.js`; a chapter gives the sliders and the data.
"""

import re
from pathlib import Path

import anywidget
import numpy as np
import traitlets

from ...arrays import shown
from ...errors import BadInput
from ...geometry import COURSE
from ..palette import PALETTE
from ..viewer.arm_data import arm_data
from ..viewer.assets import kinematics
from ..viewer.scene import mimebundle

_HERE = Path(__file__).parent
#: The figures that figures.js holds.
FIGURES = tuple(
    re.search(r"window\.OMX_FIGURES = \{ (.*) \};", (_HERE / "figures.js").read_text(encoding="utf-8"))[1].split(", ")
)
_RENDER = """
export default { render({ model, el }) {
  const box = document.createElement("div");
  box.className = "omx-panel";
  box.dataset.panel = JSON.stringify(model.get("data"));
  el.append(box);
  new window.OMX_PANEL(box);
  for (const input of box.querySelectorAll("input")) input.dataset.lmSuppressShortcuts = "true"; // or arrows fold cells
} };
"""


def script() -> str:
    """The panels' scripts as one: what a page loads after the kinematics."""
    names = ("figures.js", "chart.js", "panel.js")
    return "\n".join((_HERE / name).read_text(encoding="utf-8") for name in names)


class LiveFigure(anywidget.AnyWidget):
    """The figure `figure` of figures.js under `sliders`; the last expression of a cell shows it.

    `sliders` maps each label, with its unit in parentheses, to (low, high, first) or (low, high, first, step), in that
    unit and in the order in which the figure wants them. `alt` says what is seen. Further arguments are the figure's
    data: numbers, arrays, lists. Raises `BadInput` for another figure, or a slider that starts outside its ends.
    """

    _esm = f"const window = {{}}; // nothing of this becomes global\n{kinematics()}\n{script()}\n{_RENDER}"
    _css = (_HERE / "live_figure.css").read_text(encoding="utf-8")

    data = traitlets.Dict().tag(sync=True)

    def __init__(self, figure: str, sliders, alt: str, **data):
        if figure not in FIGURES:
            raise BadInput(f"`figure` must be one of {', '.join(FIGURES)}; got {shown(figure)}.")
        self.alt = " ".join(alt.split())
        rows = [_slider(label, *numbers) for label, numbers in sliders.items()]
        values = {**{name: _plain(value) for name, value in data.items()}, "arm": arm_data(COURSE)}
        about = {"kind": "figure", "figure": figure, "title": self.alt, "sliders": rows}
        super().__init__(data={**about, "palette": PALETTE, "data": values})

    def __repr__(self) -> str:
        starts = ", ".join(f"{name} {first:g} {unit}".rstrip() for name, unit, _, _, first, _ in self.data["sliders"])
        return f"Live figure: {self.alt}; {starts}"

    def page_data(self) -> dict:
        """All that a tool needs to put the figure on a page of its own, where `panel.js` draws it."""
        return {"title": repr(self), "panel": self.data}

    def _repr_mimebundle_(self, **_) -> dict:
        return mimebundle(self)


def _slider(label: str, low: float, high: float, first: float, step: float = 1) -> list:
    """One slider as panel.js wants it; `BadInput` for a start outside the ends."""
    if not low <= first <= high:
        raise BadInput(f"the slider `{label}` must start between {low:g} and {high:g}; got {first!r}.")
    name, unit = re.fullmatch(r"(.*?)(?: \((.*)\))?", label).groups()
    return [name, "\u00b0" if unit == "deg" else unit or "", low, high, first, step]


def _plain(value):
    """Numbers, arrays and bytes as JSON has them; twelve digits are enough for a page."""
    if isinstance(value, (bytes, bytearray)):
        return list(value)
    array = np.asarray(value, float)
    if array.ndim:
        return [_plain(part) for part in array]
    return int(array) if float(array).is_integer() else float(f"{array:.12g}")
