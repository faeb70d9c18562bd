"""The robot panel under a hand: nothing moves by itself, holding moves, letting go holds, STOP works in mid-cell."""

import time

import pytest

from tests.browser.pages import pixels
from tests.helpers.lab import run_in_kernel

PANEL = "from omx import Robot, RobotPanel\nrobot = Robot()\npanel = RobotPanel(robot)\npanel.speed.value = 5\npanel"
MOVE = """
import time
from omx import Stopped
robot.write_motor_state(True)
try:
    for q1 in (-80, 0) * 2:  # so long that a page on a busy computer is there before its end
        robot.move_to([q1, -40, 10, 20], 30)
except Stopped as reason:
    print(reason, time.time(), sep="|")
"""
#: From the press in the page to the end of the cell, on a busy computer (s).
SOON = 15.0
#: A replay must be held to its end: here a page on a busy computer may be silent for longer.
TEACH = """
from omx import Robot
from omx.display.panels import TeachPanel, robot_panel, teach_panel
robot_panel.SILENCE_S = teach_panel.SILENCE_S = 3.0
robot = Robot()
robot.write_motor_state(True)
panel = TeachPanel(robot, path="taught-in-the-browser.csv")
panel
"""


class Desk:
    """A notebook with a panel on a virtual arm, in real time."""

    def __init__(self, lab, notebook):
        self.lab, self.notebook, self.page = lab, notebook, notebook.page
        self.panel = notebook.panel()

    def button(self, name):
        return self.panel.get_by_role("button", name=name)

    def says(self):
        return self.panel.locator("[role=status]").inner_text()

    def angle(self):
        """q1 of the arm itself, not of the panel (deg)."""
        return float(self.run("import math\nprint(math.degrees(robot.arm.q[0]))"))

    def run(self, code):
        """What the kernel prints."""
        return run_in_kernel(self.lab, self.notebook.kernel["id"], code)

    def ghost_to_the_left(self):
        handle = self.panel.locator(".noUi-handle").first
        handle.focus()
        for _ in range(50):
            handle.press("ArrowRight")
        self.notebook.settle()

    def pointer_on(self, name):
        box = self.button(name).bounding_box()
        self.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)

    def hold_until(self, name, condition):
        """Press, and hold until `condition()`."""
        self.pointer_on(name)
        self._press()
        self.hold_on_until(condition)

    def hold_on_until(self, condition):
        """Go on holding; where a busy computer made the page fall silent, press again, as a reader does."""

        def seen():
            if condition():
                return True
            if "holds" in self.says():
                self.page.mouse.up()
                self._press()
            return False

        assert self.notebook.until(seen), self.says()

    def _press(self):
        self.page.mouse.down()
        self.page.wait_for_timeout(500)  # until what it says is news

    def let_go(self):
        self.page.mouse.up()
        assert self.notebook.until(lambda: "holds" in self.says())


@pytest.fixture
def desk(lab, open_page, notebook):
    page = open_page(notebook(PANEL))
    page.run_all()
    return Desk(lab, page)


def test_the_arm_moves_while_the_button_is_held_and_only_then(desk):
    desk.button("Motors on").click()
    desk.notebook.settle()
    assert "Nothing moves" in desk.says()
    scene = desk.panel.locator(".omx-scene").first
    before = pixels(scene)
    desk.ghost_to_the_left()
    assert desk.notebook.changes(scene, before, 0.002), "the ghost shows what is asked for"
    start = desk.angle()
    assert abs(start) < 1
    desk.pointer_on("Hold to move")
    desk.page.mouse.down()
    assert desk.notebook.until(lambda: desk.angle() > 3)
    desk.page.mouse.up()
    desk.notebook.settle()
    held = desk.angle()
    assert held > 3
    desk.notebook.settle()
    assert desk.angle() == pytest.approx(held, abs=0.3)
    assert held < 49, "it had not arrived when the button was let go"
    assert not desk.notebook.errors


def test_the_space_bar_holds_too_and_a_page_that_goes_ends_the_motion(desk):
    desk.button("Motors on").click()
    desk.notebook.settle()
    desk.ghost_to_the_left()
    desk.button("Hold to move").focus()
    desk.page.keyboard.down(" ")
    assert desk.notebook.until(lambda: desk.angle() > 3)
    desk.page.goto("about:blank")  # the page is gone and says nothing: the heartbeat is missing
    desk.page.wait_for_timeout(1000)
    stopped = desk.angle()
    desk.page.wait_for_timeout(700)
    assert desk.angle() == pytest.approx(stopped, abs=0.3)
    assert stopped < 49


def test_stop_works_while_a_cell_runs(lab, open_page, notebook):
    page = open_page(notebook(PANEL, MOVE))
    page.start()
    desk = Desk(lab, page)
    assert page.until(lambda: page.kernel["execution_state"] == "busy")
    page.page.wait_for_timeout(1500)
    desk.button("STOP").click()
    pressed = time.time()
    stopped = desk.angle()  # the answer comes when the cell has ended
    assert -79 < stopped < -0.05, "it was on its way"
    page.settle()
    assert "Stopped" in desk.says()
    reason, at = "".join(page.save()[1]["outputs"][0]["text"]).split("|")
    assert "stop" in reason
    assert float(at) < pressed + SOON
    assert desk.angle() == pytest.approx(stopped, abs=0.5)
    assert not page.errors


def test_an_arm_is_taught_by_hand_replayed_and_relaxed_and_each_only_while_its_button_is_held(lab, open_page, notebook):
    page = open_page(notebook(TEACH))
    page.run_all()
    desk = Desk(lab, page)
    desk.hold_until("Hold to teach", lambda: "Lead the arm" in desk.says())
    desk.run("robot.arm.push(0.4)")
    desk.hold_on_until(lambda: desk.angle() > 10)
    desk.run("robot.arm.push()")
    desk.let_go()
    assert desk.run("print(panel.teach_button.held)") == "False\n", "it was told, and did not wait for the silence"
    led = desk.angle()
    page.settle()
    assert desk.angle() == pytest.approx(led, abs=1), "it stays where it was left"
    desk.run("robot.move_to([-20, -60, 20, 40])")
    desk.hold_until("Hold to replay", lambda: desk.angle() > -17)
    desk.let_go()
    assert desk.run("print(panel.replay_button.held)") == "False\n"
    between = desk.angle()
    page.settle()
    assert desk.angle() == pytest.approx(between, abs=1)
    assert between < led - 2, "it had not arrived when the button was let go"
    desk.hold_until("Hold to replay", lambda: "Replayed" in desk.says())
    page.page.wait_for_timeout(1000)
    assert desk.angle() == pytest.approx(led, abs=2), "the button is still held, and it does not begin again"
    desk.page.mouse.up()
    desk.hold_until("Hold to relax", lambda: "SUPPORT THE ARM" in desk.says())
    desk.page.mouse.up()
    page.page.wait_for_timeout(2500)
    assert desk.run("print(robot.driver.torque)") == "True\n", "a press is not enough"
    desk.hold_until("Hold to relax", lambda: "Relaxed" in desk.says())
    desk.page.mouse.up()
    assert desk.run("print(robot.driver.torque)") == "False\n"
    assert not page.errors
