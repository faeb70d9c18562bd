"""`RobotPanel`: the joint sliders on a `Robot`. The ghost is what you ask for, the solid arm is where the arm is.

The sliders alone move nothing. Switch the motors on, set the ghost where you want the arm, and hold the button: the
arm goes there while the button is held, and no longer. Parking, too, goes on only while its button is held, and the
motors go off only when *Relax* has been held for two seconds. The page sends a heartbeat while a button is held; if the
page, the network or the kernel dies, the arm stops. The stop button works at any time, also while a cell is running.
"""

import asyncio
import contextlib
import html
import math
import sys
import threading
import weakref
from pathlib import Path

import anywidget
import ipywidgets
import traitlets

from ...arm import JOINT_IDS, PARK_SPEED
from ...dh import clipped
from ...errors import BadInput, Collision, JointLimit, NotReady, OmxError, ServoFault, Stalled, Stopped, TorqueOff
from ...hardware.clock import SteppedClock
from ...hardware.dynamixel import registers as reg
from ...hardware.robot.move_rules import way_to_rest
from ..viewer.view import View
from . import tables
from .joint_panel import JointPanel
from .panel import ViewPanel

#: Seconds between two beats of the page, and how long the arm goes on without one.
BEAT_S, SILENCE_S = 0.1, 0.35
#: Seconds between two looks at the arm.
LOOK_S = 0.1
SLOWEST_DEG, FASTEST_DEG = 5, 60
#: How long *Relax* must be held before the motors go off (s).
RELAX_S = 2.0
#: Where a way point of the parking motion counts as reached (rad).
NEAR = math.radians(0.5)

#: The panels at work: one a robot, and one a notebook cell.
_panels = weakref.WeakSet()


class HoldButton(anywidget.AnyWidget):
    """A button that counts `press` up when pressed, by mouse, finger, space bar or enter key, and `beat` while held."""

    _esm = Path(__file__).with_name("hold_button.js").read_text(encoding="utf-8")

    label = traitlets.Unicode("Hold to move").tag(sync=True)
    plain = traitlets.Bool(False).tag(sync=True)
    press = traitlets.Int(0).tag(sync=True)
    beat = traitlets.Int(0).tag(sync=True)
    held = traitlets.Bool(False).tag(sync=True)


class RobotPanel(ViewPanel):
    """Joint sliders, motors, speed, hold-to-move, stop, and the state of each servo, for `robot`.

    `watch=False` leaves out the thread that looks at the arm ten times a second; `look` does one look.
    """

    def __init__(self, robot, view: View | None = None, *, watch: bool = True):
        self._closing = threading.Event()
        robot.bus.refuse_if_read_only("put its motors under buttons")
        self.robot, self.driver = robot, robot.driver
        self._cell = _this_cell()
        for panel in [p for p in _panels if p.robot is robot or (p._cell and p._cell == self._cell)]:
            panel.close()
        if isinstance(robot.clock, SteppedClock):
            robot.clock.run()
        limits = self.driver.guard.soft_limits
        start = clipped(self.driver.read().q, limits)  # an arm that hangs without torque may lie outside its limits
        self.joints = JointPanel(view or View(start, geometry=robot.geometry), limits=limits)
        self.joints.command_a_ghost()  # the arm goes there while the button is held
        self._aim: tuple[float, ...] | None = None
        self._way: list[tuple[float, ...]] = []  # to the rest pose
        self._relaxing_since: float | None = None
        self._relax_beat_at = -math.inf
        self._silent_at = math.inf
        self._looks = 0
        super().__init__(self.joints.view, [self.joints, *self._controls()])
        self.joints.q = start
        for button in (self.hold, self.stop_button, self.resume_button, self.park_button, self.relax_button):
            heard_at_once(button)
        self._say(" ".join(self.driver.condition.warnings))
        self.look()
        _panels.add(self)
        if watch:
            self._start_watching(weakref.ref(self), self._closing)

    def _controls(self) -> list:
        """Buttons, the speed, and two lines of text: what has happened, and how the servos are."""
        self.motors = ipywidgets.ToggleButton(description="Motors on", value=self.driver.torque, icon="power-off")
        cap = max(1, math.floor(math.degrees(self.driver.guard.speed_cap)))
        slow, fast = min(SLOWEST_DEG, cap), min(FASTEST_DEG, cap)
        self.speed = ipywidgets.IntSlider(min(20, fast), slow, fast, description="speed", readout_format="d")
        self.hold = HoldButton()
        self.stop_button = ipywidgets.Button(description="STOP", button_style="danger", icon="hand-paper")
        self.stop_button.tooltip = "Hold at once; works while a cell is running"
        self.resume_button = ipywidgets.Button(description="Resume", disabled=True)
        self.park_button = HoldButton(label="Hold to park", plain=True)
        self.relax_button = HoldButton(label="Hold to relax", plain=True)
        self.message, self.state = ipywidgets.HTML(), ipywidgets.HTML()
        self.motors.observe(lambda change: self._try(self._switch, change.new), "value")
        for button, beat in ((self.hold, self._beat), (self.park_button, self._park_beat),
                             (self.relax_button, self._relax_beat)):  # fmt: skip
            button.observe(lambda _, beat=beat: self._try(beat), "beat")
        self.stop_button.on_click(lambda _: self._try(self.stop))
        self.resume_button.on_click(lambda _: self._try(self.resume))
        buttons = [self.motors, self.hold, self.stop_button, self.resume_button, self.park_button, self.relax_button]
        speed = ipywidgets.HBox([self.speed, ipywidgets.Label("deg/s")])
        return [ipywidgets.HBox(buttons), speed, self.message, self.state]

    def page_data(self) -> dict:
        """The joint sliders alone, as a page without a kernel has no robot."""
        return {**self.joints.page_data(), "robot": True}

    # ---- what the buttons do ----

    def stop(self) -> None:
        """Hold at once, and refuse every command until `resume`."""
        self._aim, self._silent_at = None, math.inf
        self.resume_button.disabled = False
        self.driver.stop()
        self._say("Stopped. The arm holds. Press Resume when it may move again.")

    def resume(self) -> None:
        """Allow commands again, and switch on again what an error of its own has switched off."""
        self.driver.resume()
        if any(self.robot.bus.read_all(JOINT_IDS, "hardware_error").values()):
            self.driver.recover()
        self.resume_button.disabled = True
        self._say("")

    def close(self) -> None:
        """End the looks at the arm. The robot stays as it is."""
        self._closing.set()
        _panels.discard(self)
        super().close()

    def _switch(self, on: bool) -> None:
        if on == self.driver.torque:
            return
        if on:
            self.driver.torque_on()
            self.joints.q = clipped(self.driver.read().q, self.driver.guard.soft_limits)
            self._say("Motors on. Nothing moves before you hold the button.")
        else:
            self.motors.value = True
            self._say(
                "The motors stay on. Hold Park to fold the arm and switch them off; or support it and hold Relax."
            )

    def _beat(self) -> None:
        """One beat of the page: a step towards the ghost, or the end of the motion."""
        if self._held(self.hold):
            self._step(self.joints.q, math.radians(self.speed.value))

    def _park_beat(self) -> None:
        """One beat: a step on the way to the rest pose; at its end the motors go off."""
        if not self._held(self.park_button) or not self.driver.torque:
            return
        if self._aim is None:
            self._way = way_to_rest(self.driver.guard, self.driver.read().aim)
        if self._step(self._way[0], min(math.radians(self.speed.value), PARK_SPEED)):
            del self._way[0]
        if not self._way:
            self._let_go()
            self.driver.wait()
            self.driver.relax()
            self._say("Parked, motors off.")
            self.motors.value = False

    def _relax_beat(self) -> None:
        """One beat: when it has been held for `RELAX_S` the motors go off."""
        now, last = self.robot.clock.now(), self._relax_beat_at
        self._relax_beat_at = now
        if not self.relax_button.held or not self.driver.torque:
            self._relaxing_since = None
        elif self._relaxing_since is None or now - last > SILENCE_S:
            self._relaxing_since = now
            self._say(f"SUPPORT THE ARM. Its motors go off when you have held the button for {RELAX_S:.0f} s.")
        elif now - self._relaxing_since >= RELAX_S:
            self.driver.relax()
            self._say("Relaxed: the motors are off, and the arm can be moved by hand.")
            self.motors.value = False

    def _held(self, button: HoldButton) -> bool:
        """Is the button held? If not, what it moved stops."""
        if not button.held:
            self._let_go()
        return button.held

    def _step(self, goal, speed: float) -> bool:
        """A step (rad) towards `goal`, as far as the arm goes between two beats; True if that is the last."""
        reading = self.driver.read()
        here = self._aim or reading.aim
        far = max(abs(a - b) for a, b in zip(goal, here, strict=True))
        share = min(1.0, speed * BEAT_S / far) if far else 1.0
        self._aim = tuple(a + share * (b - a) for a, b in zip(here, goal, strict=True))
        self._silent_at = self.robot.clock.now() + SILENCE_S
        self.driver.stream_to(self._aim, 2 * BEAT_S)
        return share == 1.0 and max(abs(a - b) for a, b in zip(goal, reading.aim, strict=True)) < NEAR

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
        if (q := self.driver.read().q) != self.view.q or self.view.animated:  # an arm at rest is not drawn again
            self.view.q = q
        if self._looks % round(1 / LOOK_S) == 0:
            self.state.value = self._table()
            self.motors.value, self.resume_button.disabled = self.driver.torque, self.driver.stopped is None
        self._looks += 1

    def _start_watching(self, *looks) -> None:
        if sys.platform == "emscripten":  # a browser's Python has no threads: it looks between two cells
            self._task = asyncio.ensure_future(_watch_between_cells(*looks))
        else:
            self._thread = threading.Thread(target=_watch, args=looks, name="omx panel", daemon=True)
            self._thread.start()

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
            self.resume_button.disabled = self.driver.stopped is None and not isinstance(error, ServoFault)
            self._say(_in_buttons(error), wrong=True)
            self.motors.value = self.driver.torque

    def _say(self, text: str, wrong: bool = False) -> None:
        self.message.value = tables.notice(text, good=not wrong)


def _watch(panel, closing: threading.Event) -> None:
    """Ten looks a second, until the panel is closed or nobody has it any more."""
    while not closing.wait(LOOK_S) and _looked(panel()):
        pass


async def _watch_between_cells(panel, closing: threading.Event) -> None:
    """The same looks, in turn with the cells."""
    while not closing.is_set() and _looked(panel()):
        await asyncio.sleep(LOOK_S)


def _looked(panel: RobotPanel | None) -> bool:
    """One look, if there is still something to look at."""
    if panel is None or not panel.robot.bus.is_open:
        return False
    panel._try(panel.look)
    return True


def _this_cell() -> str | None:
    """The id of the notebook cell that is being run, where JupyterLab tells it."""
    ipython = sys.modules.get("IPython")
    kernel = getattr(ipython.get_ipython() if ipython else None, "kernel", None)
    return kernel.get_parent().get("metadata", {}).get("cellId") if kernel else None


def _in_buttons(error: OmxError) -> str:
    """What went wrong, with the buttons of this panel for the calls of a program."""
    if isinstance(error, TorqueOff):
        return "The motors are off. Press Motors on: the arm stays where it is."
    if isinstance(error, Stopped):
        return f"The arm holds: {error.why}. Press Resume when it may move again."
    if isinstance(error, Stalled):
        return f"{str(error).partition(';')[0]}. Then press Resume."
    if isinstance(error, ServoFault):
        causes = "; ".join(f"servo {servo}: {', '.join(words)}" for servo, words in error.causes.items())
        return f"{causes}. Support the arm, remove the cause, then press Resume: that servo restarts."
    if isinstance(error, (Collision, JointLimit)):
        return f"{error} Move the sliders so that the pale arm is free, and hold the button again."
    if isinstance(error, (BadInput, NotReady)) and "write_motor_state" in str(error):
        return f"{str(error).partition(': `robot')[0]}. Hold Relax, then press Motors on."
    return str(error)


def heard_at_once(widget) -> None:
    """Let the kernel take this widget's messages where JupyterLab sends them: to a shell of their own.

    From 7.4 on ipykernel hands them to the shell that wrote to the widget last, which is the one that runs the cells:
    a press on STOP would wait for the end of the very motion it is to stop.
    """
    if widget.comm is not None:
        widget.comm._reply_subshell_for = lambda data, asked_for: asked_for
