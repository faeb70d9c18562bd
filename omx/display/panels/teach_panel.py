"""`TeachPanel`: lead an arm by hand, let it do the same again, or let it follow another one, while a button is held.

The buttons of `RobotPanel` are above: motors, STOP, and the rest. Whoever lets go of a button, or loses the page,
makes the arm hold.
"""

import sys
import threading

import ipywidgets

from ...dh import clipped
from ...errors import BadInput
from ...hardware.log import read_log
from ...hardware.robot import hand_guiding
from ...motion.trajectory import joint_move
from ..viewer.view import View
from .robot_panel import SILENCE_S, HoldButton, RobotPanel, heard_at_once

#: Turns a second of a replay, and of following a leader.
REPLAY_RATE, LEAD_RATE = 50.0, 100.0
#: The longest (s) that a button is held, and the slowest and fastest replay.
LONGEST_S, SPEEDS = 600.0, (0.25, 2.0)


class Released(Exception):
    """Nobody holds the button any more."""


class TeachPanel(RobotPanel):
    """*Hold to teach*, *Hold to replay* and, with a `leader`, *Hold to follow*, for `robot`.

    What was taught is the log at `path`; one that is there already can be replayed. `leader`: another `Robot`, or a
    function that returns four angles (deg); it is followed a hundred times a second. Every motion passes the guard.
    `watch=False` leaves out the threads: a button's first beat then does all until nobody holds it.
    """

    def __init__(self, robot, leader=None, *, path="taught.csv", view: View | None = None, watch: bool = True):
        if watch and sys.platform == "emscripten":
            raise BadInput("`TeachPanel` needs threads, which a browser's Python has not: use `robot.teach`.")
        self.leader, self.path = leader, path
        self._released_at, self._threads = 0.0, watch
        self._begun = None, 0  # by which press of which button: one press begins one thing, however long it is held
        self._running = threading.Lock()
        super().__init__(robot, view, watch=watch)
        self.teach_button = self._button("Hold to teach", self._teach)
        self.replay_button = self._button("Hold to replay", self._replay)
        self.follow_button = self._button("Hold to follow", self._follow)
        slow, fast = SPEEDS
        self.replay_speed = ipywidgets.FloatSlider(1.0, min=slow, max=fast, step=0.25, description="replay")
        buttons = [self.teach_button, self.replay_button, *([self.follow_button] if leader else [])]
        replay = [self.replay_speed, ipywidgets.Label("times as fast as taught")]
        self.children = [*self.children, ipywidgets.HBox(buttons), ipywidgets.HBox(replay)]

    def close(self) -> None:
        """End what runs, and the looks at the arm. The robot stays as it is."""
        self._released_at = 0.0
        super().close()

    # ---- the buttons ----

    def _button(self, label: str, action) -> HoldButton:
        button = HoldButton(label=label, plain=True)
        button.observe(lambda _: self._hold_beat(button, action), "beat")
        heard_at_once(button)
        return button

    def _hold_beat(self, button: HoldButton, action) -> None:
        """One beat of the page: begin, go on, or end."""
        self._released_at = self.robot.clock.now() + SILENCE_S if button.held else 0.0
        if button.held and self._begun != (button, button.press) and not self._running.locked():
            self._begun = button, button.press
            if self._threads:
                threading.Thread(target=self._run, args=[action], name="omx teach panel", daemon=True).start()
            else:
                self._run(action)

    def _run(self, action) -> None:
        """Do it until nobody holds the button; what goes wrong is told above, and the arm holds."""
        with self._running:
            self._try(self._until_released, action)

    def _until_released(self, action) -> None:
        try:
            action()
        except Released:
            self.joints.q = clipped(self.robot.q, self.robot.driver.guard.soft_limits)
            self._say("The arm holds.")
        finally:
            self._released_at = 0.0

    def _check_held(self, *_) -> None:
        if self.robot.clock.now() > self._released_at:
            raise Released

    # ---- what they do ----

    def _teach(self) -> None:
        self._say("Lead the arm. It carries its weight; keep a hand at it.")
        self.robot.teach(LONGEST_S, self.path, progress=self._check_held)

    def _replay(self) -> None:
        motion = hand_guiding.trajectory(read_log(self.path), self.replay_speed.value)
        hand_guiding.check_speed(self.robot.driver, motion, self.replay_speed.value)
        here, there = self.robot.q, motion.q[0]
        self._say("Replaying.")
        seconds = 2.0 * self.robot.driver.guard.seconds(here, there) + 0.5
        for part in (joint_move(here, there, seconds), motion):
            self.robot.follow(part, REPLAY_RATE, each=self._check_held)
        self._say("Replayed. The arm holds.")

    def _follow(self) -> None:
        def where():
            self._check_held()
            return self.leader() if callable(self.leader) else self.leader.get_joints_readings()[0]

        self._say("Following.")
        self.robot.follow_leader(where, LONGEST_S, LEAD_RATE)
