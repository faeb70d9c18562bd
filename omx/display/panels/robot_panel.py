"""`RobotPanel`: the joint sliders on a `Robot`. The ghost is what you ask for, the solid arm is where the arm is.

The sliders alone move nothing. Switch the motors on, set the ghost where you want the arm, and hold the button: the
arm goes there while the button is held, and no longer. The page sends a heartbeat while it is held; if the page, the
network or the kernel dies, the arm stops. The stop button works at any time, also while a cell is running.
"""

import contextlib
import html
import math
import threading

import anywidget
import ipywidgets
import traitlets

from ...arm import JOINT_IDS
from ...errors import OmxError
from ...hardware.clock import SteppedClock
from ...hardware.dynamixel import registers as reg
from ..viewer.scene import mimebundle
from ..viewer.view import View
from .joint_panel import JointPanel

#: Seconds between two beats of the page, and how long the arm goes on without one.
BEAT_S, SILENCE_S = 0.1, 0.35
#: Seconds between two looks at the arm.
LOOK_S = 0.1
SLOWEST_DEG, FASTEST_DEG = 5, 60


class HoldButton(anywidget.AnyWidget):
    """A button that counts `beat` up while it is held down, by mouse, finger, space bar or enter key."""

    _esm = """
    function render({ model, el }) {
      const button = document.createElement("button");
      button.className = "jupyter-widgets jupyter-button widget-button mod-primary";
      button.style.cssText = "width:auto;padding:0 18px;touch-action:none;user-select:none";
      button.textContent = model.get("label");
      let timer = null;
      const send = (held) => {
        model.set({ held, beat: model.get("beat") + 1 });
        model.save_changes();
      };
      const start = () => { if (timer === null) { send(true); timer = setInterval(() => send(true), 100); } };
      const end = () => { if (timer !== null) { clearInterval(timer); timer = null; send(false); } };
      const key = (event) => event.key === " " || event.key === "Enter";
      button.addEventListener("pointerdown", (event) => { button.setPointerCapture(event.pointerId); start(); });
      const ends = ["pointerup", "pointercancel", "lostpointercapture", "blur"];
      for (const name of ends) button.addEventListener(name, end);
      button.addEventListener("keydown", (event) => { if (key(event)) { event.preventDefault(); start(); } });
      button.addEventListener("keyup", (event) => { if (key(event)) end(); });
      const hidden = () => { if (document.hidden) end(); };
      document.addEventListener("visibilitychange", hidden);
      el.appendChild(button);
      return () => { end(); document.removeEventListener("visibilitychange", hidden); };
    }
    export default { render };
    """

    label = traitlets.Unicode("Hold to move").tag(sync=True)
    beat = traitlets.Int(0).tag(sync=True)
    held = traitlets.Bool(False).tag(sync=True)


class RobotPanel(ipywidgets.VBox):
    """Joint sliders, motors, speed, hold-to-move, stop, and the state of each servo, for `robot`.

    `watch=False` leaves out the thread that looks at the arm ten times a second; `look` does one look.
    """

    def __init__(self, robot, view: View | None = None, *, watch: bool = True):
        self.robot, self.driver = robot, robot.driver
        if isinstance(robot.clock, SteppedClock):
            robot.clock.run()
        limits = self.driver.guard.soft_limits
        start = _inside(self.driver.read().q, limits)  # an arm that hangs without torque may lie outside its limits
        self._closing = threading.Event()
        self.joints = JointPanel(view or View(start, geometry=robot.geometry), limits=limits)
        self.joints.on_command = lambda q: None  # the ghost alone; the arm goes there while the button is held
        self._aim: tuple[float, ...] | None = None
        self._silent_at = math.inf
        self._looks = 0
        self.motors = ipywidgets.ToggleButton(description="Motors on", value=self.driver.torque, icon="power-off")
        self.speed = ipywidgets.IntSlider(20, SLOWEST_DEG, FASTEST_DEG, description="speed", readout_format="d")
        self.hold = HoldButton()
        self.stop_button = ipywidgets.Button(description="STOP", button_style="danger", icon="hand-paper")
        self.stop_button.tooltip = "Hold at once; works while a cell is running"
        self.resume_button = ipywidgets.Button(description="Resume", disabled=True)
        self.park_button = ipywidgets.Button(description="Park")
        self.park_button.tooltip = "Fold the arm slowly, then motors off"
        self.message, self.state = ipywidgets.HTML(), ipywidgets.HTML()
        self.motors.observe(lambda change: self._try(self._switch, change.new), "value")
        self.hold.observe(lambda _: self._try(self._beat), "beat")
        self.stop_button.on_click(lambda _: self._try(self.stop))
        self.resume_button.on_click(lambda _: self._try(self.resume))
        self.park_button.on_click(lambda _: self._try(self.park))
        unit = ipywidgets.Label("deg/s")
        buttons = [self.motors, self.hold, self.stop_button, self.resume_button, self.park_button]
        super().__init__([self.joints, ipywidgets.HBox(buttons), ipywidgets.HBox([self.speed, unit]), self.message,
                          self.state])  # fmt: skip
        self.joints.q = start
        for button in (self.hold, self.stop_button, self.resume_button):
            _heard_at_once(button)
        self.look()
        if watch:
            threading.Thread(target=self._watch, name="omx panel", daemon=True).start()

    def __repr__(self) -> str:
        return f"RobotPanel: {self.joints.view!r}"

    def static_html(self, *, shared: bool = False) -> str:
        """The joint sliders alone, as a page without a kernel has no robot."""
        return self.joints.static_html(shared=shared)

    def _repr_mimebundle_(self, **_) -> dict:
        return mimebundle(self.joints.view, self)

    # ---- what the buttons do ----

    def stop(self) -> None:
        """Hold at once, and refuse every command until `resume`."""
        self._aim, self._silent_at = None, math.inf
        self.resume_button.disabled = False
        self.driver.stop()
        self._say("Stopped. The arm holds. Press Resume when it may move again.")

    def resume(self) -> None:
        """Allow commands again."""
        self.driver.resume()
        self.resume_button.disabled = True
        self._say("")

    def park(self) -> None:
        """Fold the arm and switch the motors off."""
        self.driver.park()
        self.motors.value = False

    def close(self) -> None:
        """End the looks at the arm. The robot stays as it is."""
        self._closing.set()
        super().close()

    def _switch(self, on: bool) -> None:
        if on == self.driver.torque:
            return
        if on:
            self.driver.torque_on()
            self.joints.q = _inside(self.driver.read().q, self.driver.guard.soft_limits)
            self._say("Motors on. Nothing moves before you hold the button.")
        else:
            self.driver.park()
            self._say("Parked, motors off.")

    def _beat(self) -> None:
        """One beat of the page: a step towards the ghost, or the end of the motion."""
        if not self.hold.held:
            self._let_go()
            return
        here = self._aim or self.driver.read().q
        step = math.radians(self.speed.value) * BEAT_S
        far = max(abs(a - b) for a, b in zip(self.joints.q, here, strict=True))
        share = min(1.0, step / far) if far else 1.0
        self._aim = tuple(a + share * (b - a) for a, b in zip(here, self.joints.q, strict=True))
        self._silent_at = self.robot.clock.now() + SILENCE_S
        self.driver.stream_to(self._aim, 2 * BEAT_S)

    def _let_go(self) -> None:
        if self._aim is not None:
            self._aim, self._silent_at = None, math.inf
            self.driver.hold()

    # ---- looking ----

    def look(self) -> None:
        """One look at the arm: the solid arm goes where it is, and now and then the servos' state is written."""
        if self.robot.clock.now() > self._silent_at:
            self._let_go()
            self._say("The page went silent, so the arm holds. Release the button and hold it again.")
        self.joints.show(self.driver.read().q)
        if self._looks % round(1 / LOOK_S) == 0:
            self.state.value = self._table()
        self._looks += 1

    def _watch(self) -> None:
        while not self._closing.wait(LOOK_S) and self.robot.bus.is_open:
            self._try(self.look)

    def _table(self) -> str:
        health = reg.block("present_voltage", "present_temperature")
        bus, servos = self.robot.bus, JOINT_IDS
        rows = []
        readings, errors = bus.read_block(servos, health), bus.read_all(servos, "hardware_error")
        for joint, (servo, mA) in enumerate(zip(servos, self.driver.read().current, strict=True), start=1):
            volts, degrees = readings[servo]
            words = ", ".join(reg.hardware_errors(errors[servo])) or "ok"
            numbers = (f"{degrees} &deg;C", f"{volts / 10:.1f} V", f"{mA:.0f} mA".replace("-", "\u2212"))
            rows.append((f"joint {joint}", *numbers, html.escape(words)))
        cells = "".join("<tr>" + "".join(f"<td style='padding:0 10px'>{c}</td>" for c in row) + "</tr>" for row in rows)
        return f"<table aria-label='State of the servos'>{cells}</table>"

    def _try(self, action, *args) -> None:
        """Do it; what is refused or fails is told in the panel, and the arm holds."""
        try:
            action(*args)
        except OmxError as error:
            with contextlib.suppress(OmxError):
                self._let_go()
            self._say(str(error), wrong=True)
            self.motors.value = self.driver.torque

    def _say(self, text: str, wrong: bool = False) -> None:
        colour = "#b00020" if wrong else "inherit"
        self.message.value = f"<span role='status' style='color:{colour}'>{html.escape(text)}</span>"


def _inside(q, limits) -> tuple[float, ...]:
    return tuple(min(max(value, low), high) for value, (low, high) in zip(q, limits, strict=True))


def _heard_at_once(widget) -> None:
    """Let the kernel take this widget's messages where JupyterLab sends them: to a shell of their own.

    From 7.4 on ipykernel hands them to the shell that wrote to the widget last, which is the one that runs the cells:
    a press on STOP would wait for the end of the very motion it is to stop.
    """
    if widget.comm is not None:
        widget.comm._reply_subshell_for = lambda data, asked_for: asked_for
