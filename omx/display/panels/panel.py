"""What panels share: a view, its joint values, and one way out for commands."""

import ipywidgets

from ...arrays import shown
from ...errors import BadInput
from ..viewer.channel import running_loop
from ..viewer.scene import Scene, mimebundle
from ..viewer.view import View

#: Seconds until the numbers follow the arm, which moves first.
_TEXT_S = 1 / 20

#: How many values told to sliders are remembered until the page answers them.
_REMEMBERED = 40


def as_view(value) -> View:
    """`value`, if it is a `View`; `BadInput` otherwise."""
    if isinstance(value, View):
        return value
    raise BadInput(f"`view` must be a View, such as omx.View() or omx.View.of_chain(chain); got {shown(value)}.")


class Later:
    """Calls `action()` in `seconds`, once however often it is asked to until then; at once where no event loop runs."""

    def __init__(self, action, seconds: float):
        self._action, self._seconds, self._asked = action, seconds, False

    def __call__(self) -> None:
        loop = running_loop()
        if loop is None:
            self._action()
        elif not self._asked:
            self._asked = True
            loop.call_later(self._seconds, self._act)

    def _act(self) -> None:
        self._asked = False
        self._action()


class ViewPanel(ipywidgets.VBox):
    """Boxes with a 3-D `view` in the first of them, as a cell and a page show it."""

    def __init__(self, view: Scene, children):
        self.view = view
        super().__init__(children)

    def page_data(self) -> dict:
        """All that a tool needs to put the panel on a page: its scene's and, as `panel`, what `panel.js` has to know.

        That script makes the controls of a page without a kernel, and moves the arm by the generated formulas.
        """
        return self.view.page_data()

    def __repr__(self) -> str:
        return f"{type(self).__name__}: {self.view!r}"

    def _repr_mimebundle_(self, **_) -> dict:
        return mimebundle(self)


class SliderPanel(ViewPanel):
    """A view above sliders, with words (`_text`) beside them. A panel of its own hears the sliders: `_heard(change)`.

    `rows`: name, unit, low end, high end and, if it is not 1, step of each slider. Boxes may stand `below` the sliders,
    `beside` them under the words, and `after` them all.
    """

    def __init__(self, view: Scene, rows, below=(), beside=(), after=()):
        made = [_slider_row(*row) for row in rows]
        self.sliders = [slider for slider, _ in made]
        for slider in self.sliders:
            slider.observe(self._heard, "value")
        self._text = ipywidgets.HTML()
        sliders = ipywidgets.VBox([*(line for _, line in made), *below])
        layout = ipywidgets.Layout(flex_flow="row wrap", align_items="flex-start", grid_gap="4px 24px")
        sides = ipywidgets.Box([sliders, ipywidgets.VBox([self._text, *beside])], layout=layout)
        super().__init__(view, [view.widget, sides, *after])


class Panel(SliderPanel):
    """A view above sliders for its joint values. A panel of its own sets `chain` before, whose limits count.

    What is commanded moves the arm in the view, or only a ghost of it: see `command_a_ghost`.
    """

    def __init__(self, view: View, rows, q, **boxes):
        self._ghostly = False
        view.on_drag = self._dragged
        self._quiet = False
        self._values: list[float] = []
        self._told: list[tuple[int, float]] = []
        self._q = view.q
        self._tell = Later(self._write, _TEXT_S)
        super().__init__(view, rows, **boxes)
        self.q = q

    def command_a_ghost(self) -> None:
        """Show commands as a ghost from now on; the solid arm stands where `view.q` puts it: where a real arm is."""
        self._ghostly = True
        self.view.channel.set("/meshcat/arm", "follows", False)  # nor does it follow a dragged tool

    @property
    def q(self) -> tuple[float, ...]:
        """The joint values last commanded, rad. Setting them moves sliders and arm; `JointLimit` outside the limits."""
        return self._q

    @q.setter
    def q(self, value) -> None:
        q = self.view.check(value)
        self.chain.check(q)
        self._place(q)

    def _place(self, q) -> None:
        """Joint values set from outside: command them and let the sliders follow."""
        self._command(q)
        self._set_sliders(q)

    def _dragged(self, _pose, q) -> None:
        """The reader has dragged the tool in the scene, or pulled a link."""
        if q is not None:
            self._place(self.view.check(q))

    def _command(self, q) -> None:
        self._q = q
        if self._ghostly:
            self.view.ghosts([q])
        else:
            self.view.q = q
        self._tell()

    def _set_sliders(self, q) -> None:
        """Move the sliders without hearing them."""
        self._values = self._slider_values(q)
        self._told = [*self._told, *enumerate(self._values)][-_REMEMBERED:]
        self._quiet = True
        try:
            for slider, value in zip(self.sliders, self._values, strict=True):
                slider.value = value
        finally:
            self._quiet = False

    def _heard(self, change) -> None:
        """A slider was moved. The others keep the exact values that they stand for."""
        if self._quiet:
            return
        i, value = self.sliders.index(change["owner"]), change["new"]
        if not self._is_echo(i, value):
            self._told.clear()
            self._values[i] = value
            self._on_sliders(list(self._values))

    def _is_echo(self, i: int, value: float) -> bool:
        """Is this the page's answer to a value that it was told, rounded to a whole step? There is one for each."""
        near = 0.5 * self.sliders[i].step + 1e-9
        answered = next((told for told in self._told if told[0] == i and abs(value - told[1]) <= near), None)
        if answered:
            self._told.remove(answered)
        return answered is not None


def _slider_row(name: str, unit: str, low: float, high: float, step: float = 1.0):
    """A slider in `unit` and the row that shows its limits, on a phone below it; arrow keys move it by `step`."""
    slider = ipywidgets.FloatSlider(
        value=min(max(0.0, low), high), min=low, max=high, step=step, description=name, readout_format=".1f",
        layout=ipywidgets.Layout(width="340px"), style={"description_width": "48px"},
    )  # fmt: skip
    room = ipywidgets.Layout(min_width="120px", flex="0 0 auto")
    limits = ipywidgets.Label(f"{_plain(low)} to {_plain(high)} {unit}", layout=room)
    return slider, ipywidgets.HBox([slider, limits], layout=ipywidgets.Layout(flex_flow="row wrap"))


def _plain(value: float) -> str:
    return f"{value:g}".replace("-", "\u2212")
