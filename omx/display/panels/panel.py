"""What panels share: a view, its joint values, and one way out for commands."""

import html
import json
import time

import ipywidgets

from ...arrays import shown
from ...errors import BadInput
from ..viewer.channel import running_loop
from ..viewer.scene import Scene, mimebundle
from ..viewer.view import View

#: Seconds between two commands to whatever `on_command` drives, and between two updates of the numbers.
COMMAND_INTERVAL, TEXT_INTERVAL = 1 / 30, 1 / 20

#: How many values told to sliders are remembered until the page answers them.
_REMEMBERED = 40


def as_view(value) -> View:
    """`value`, if it is a `View`; `BadInput` otherwise."""
    if isinstance(value, View):
        return value
    raise BadInput(f"`view` must be a View, such as omx.View() or omx.View.of_chain(chain); got {shown(value)}.")


class Latest:
    """Calls `action(value)` at once, or when `interval` seconds since the last call have passed, with the newest value.

    With `eager` False even the first value waits, so that more urgent messages go first. Without a running
    event loop nothing could call later, so then every value is passed on at once.
    """

    def __init__(self, action, interval: float, *, eager: bool = True):
        self._action, self._interval, self._eager = action, interval, eager
        self._due = 0.0
        self._waiting: list = []

    def __call__(self, value) -> None:
        wait = self._due - time.monotonic() if self._eager else self._interval
        loop = running_loop()
        if wait <= 0 or loop is None:
            self._waiting.clear()
            self._call(value)
        elif self._waiting:
            self._waiting[0] = value
        else:
            self._waiting.append(value)
            loop.call_later(wait, self.flush)

    def flush(self) -> None:
        """Pass on the value that is waiting, if any."""
        if self._waiting:
            self._call(self._waiting.pop())

    def _call(self, value) -> None:
        self._due = time.monotonic() + self._interval
        self._action(value)


class ViewPanel(ipywidgets.VBox):
    """Boxes with a 3-D `view` in the first of them, as a cell and a page show it."""

    def __init__(self, view: Scene, children):
        self.view = view
        super().__init__(children)

    def _static_data(self) -> dict:
        """What `panel.js` has to know to make the controls of a page without a kernel."""
        raise NotImplementedError

    def static_html(self) -> str:
        """The panel without a kernel: the scene in a mark that the site's script fills with sliders of its own.

        That script moves the arm by the generated formulas in JavaScript.
        """
        data = html.escape(json.dumps(self._static_data()))
        return f'<div class="omx-panel" data-panel="{data}">{self.view.static_html()}</div>'

    def __repr__(self) -> str:
        return f"{type(self).__name__}: {self.view!r}"

    def _repr_mimebundle_(self, **_) -> dict:
        return mimebundle(self)


class Panel(ViewPanel):
    """A view under sliders for its joint values. A panel of its own sets `sliders`, and `chain`, whose limits count.

    `on_command(q)` is the panel's one way out: left None, a command moves the arm in the view. Set to a function,
    it gets each commanded q instead, at most 30 a second and always the last; the command is then shown as a
    ghost, and the solid arm stands where `show(q)` puts it: where a real arm is.
    """

    def __init__(self, view: View, controls, q):
        self._on_command = None
        view.on_drag = self._dragged
        self._quiet = False
        self._values: list[float] = []
        self._told: list[tuple[int, float]] = []
        self._q = view.q
        self._forward = Latest(lambda q: self.on_command and self.on_command(q), COMMAND_INTERVAL)
        self._tell = Latest(lambda _: self._write(), TEXT_INTERVAL, eager=False)  # the arm moves first
        super().__init__(view, [view.widget, *controls])
        self.q = q

    @property
    def on_command(self):
        """None, or the function that gets each commanded q."""
        return self._on_command

    @on_command.setter
    def on_command(self, function) -> None:
        self._on_command = function
        self.view.follow_drags(function is None)

    @property
    def q(self) -> tuple[float, ...]:
        """The joint values last commanded, rad. Setting them moves sliders and arm; `JointLimit` outside the limits."""
        return self._q

    @q.setter
    def q(self, value) -> None:
        q = self.view.check(value)
        self.chain.check(q)
        self._place(q)

    def show(self, q) -> None:
        """Put the solid arm at `q`, without a command: what a real arm reports."""
        self.view.q = q

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
        if self.on_command is None:
            self.view.q = q
        else:
            self.view.ghosts([q])
            self._forward(q)
        self._tell(None)

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


def slider_row(name: str, low: float, high: float, value: float, unit: str, step: float = 1.0):
    """A slider in `unit` and the row that shows its limits; arrow keys move it by `step`."""
    slider = ipywidgets.FloatSlider(
        value=min(max(value, low), high), min=low, max=high, step=step, description=name, readout_format=".1f",
        layout=ipywidgets.Layout(width="340px"), style={"description_width": "48px"},
    )  # fmt: skip
    room = ipywidgets.Layout(min_width="120px", flex="0 0 auto")
    limits = ipywidgets.Label(f"{_plain(low)} to {_plain(high)} {unit}", layout=room)
    return slider, ipywidgets.HBox([slider, limits])


def side_by_side(*children):
    """Boxes beside each other, below each other where the page is narrow."""
    layout = ipywidgets.Layout(flex_flow="row wrap", align_items="flex-start", grid_gap="4px 24px")
    return ipywidgets.Box(list(children), layout=layout)


def _plain(value: float) -> str:
    return f"{value:g}".replace("-", "\u2212")
