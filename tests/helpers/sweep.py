"""One fault at the k-th packet of a short programme, for every k: whatever happens, the end is one that is known.

`python -m tests.helpers.sweep` runs all faults at all packets and says what it saw; `--stride 20` every twentieth.
"""

import argparse
import collections
import logging
import math
import random
import sys
import time
import traceback

import numpy as np

from omx.arm import JOINT_IDS, REST
from omx.errors import OmxError, OutOfBounds
from omx.hardware.robot import Robot, modes
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort
from tests.helpers.programs import Broken, Trial

#: Where the programme begins: near the rest pose, for short ways.
START = (0.0, -1.40, 1.15, 0.3)
#: What the programme must not even notice: a packet, or an answer, that did not come whole, or a computer held up.
HARMLESS = ("request swallowed", "request garbled", "answer lost", "answer corrupt", "answer truncated", "answer late",
            "answer doubled", "noise", "held up 0.3 s", "held up 5 s")  # fmt: skip
#: Why a motor may be off at the end though nobody switched it off.
LIMP = ("overload 13", "dead 12", "no_power", "9 V")


class Line(VirtualPort):
    """A port that counts its packets, and has `spoil(line, packet)` send the one with number `at`."""

    def __init__(self, arm, clock, at: float, spoil):
        super().__init__(arm, clock)
        self.count, self.at, self.spoil, self.breaks = 0, at, spoil, False
        self.places: list[tuple] = []  # where in the code each packet was sent

    def writePort(self, packet):
        self.count += 1
        if self.at == math.inf:
            self.places.append(tuple((f.f_code, f.f_lineno) for f, _ in traceback.walk_stack(None)))
        return self.spoil(self, bytes(packet)) if self.count == self.at else self.go(packet)

    def go(self, packet):
        return super().writePort(packet)

    def readPort(self, length):
        if self.breaks:
            self.breaks = False
            raise KeyboardInterrupt
        return super().readPort(length)


def _first(action):
    """The fault happens, then the packet goes out."""

    def spoil(line, packet):
        action(line)
        return line.go(packet)

    return spoil


def _fault(kind: str, **options):
    return _first(lambda line: line.arm.faults.inject(kind, **options))


def _swallowed(line, packet):
    line.sent, line.received = packet, bytearray()
    return len(packet)


def _garbled(line, packet):
    line.go(packet[:-3] + bytes([packet[-3] ^ 0x10]) + packet[-2:])
    return len(packet)


def _interrupted(line, packet):
    raise KeyboardInterrupt


def _interrupted_after(line, packet):
    line.go(packet)
    raise KeyboardInterrupt


def _interrupted_reading(line, packet):
    line.breaks = True
    return line.go(packet)


#: name -> what becomes of the k-th packet.
SPOILS = {
    "request swallowed": _swallowed,
    "request garbled": _garbled,
    "answer lost": _fault("lost", count=1),
    "2 answers lost": _fault("lost", count=2),
    "5 answers lost": _fault("lost", count=5),
    "answer corrupt": _fault("corrupt", count=1),
    "4 answers corrupt": _fault("corrupt", count=4),
    "answer truncated": _fault("truncated", count=1),
    "answer late": _fault("late", count=1),
    "answer doubled": _fault("duplicated", count=1),
    "noise": _fault("noise", count=1),
    "interrupt before": _interrupted,
    "interrupt after": _interrupted_after,
    "interrupt in the answer": _interrupted_reading,
    "12 reboots": _fault("reboots", servo=12),
    "14 reboots": _fault("reboots", servo=14),
    "gripper reboots": _fault("reboots", servo=15),
    "overload 13": _fault("overload", servo=13),
    "dead 12": _fault("dead", servo=12),
    "dead gripper": _fault("dead", servo=15),
    "no_power": _fault("no_power"),
    "plug pulled": _fault("unplugged"),
    "held up 0.3 s": _first(lambda line: line.clock.sleep(0.3)),
    "held up 5 s": _first(lambda line: line.clock.sleep(5.0)),
    "hot 13": _fault("hot", servo=13, value=75.0),
    "9 V": _fault("low_voltage", value=9.0),
}


class Sweep(Trial):
    """The programme with `SPOILS[name]` at packet `k`."""

    def __init__(self, name: str | None = None, k: float = math.inf):
        super().__init__(random.Random(0), VirtualArm(q=START))
        self.name, self.error = name, None
        self.spoilt: set[str] = set()  # the functions that sent the packet
        self.line = Line(self.arm, SteppedClock(), k, self._spoil)
        self.told = [f"{name} at packet {k}"]

    def _spoil(self, line, packet):
        self.spoilt = {f.f_code.co_name for f, _ in traceback.walk_stack(None)}
        if "interrupt" in self.name:
            self.stopped_at = self.arm.now  # somebody wants the arm to stand
        return SPOILS[self.name](line, packet)

    def run(self) -> str:
        """Run it and judge it; returns how it ended, in a word or two."""
        log = logging.getLogger("omx.robot")
        log.addHandler(self.heard)
        log.propagate = False
        try:
            self._programme()
            self.arm.advance(self.arm.now + 4.0)
            end = self._end()
            self.judge()
            self._again()
            return end
        finally:
            log.removeHandler(self.heard)
            log.propagate = True

    def _programme(self) -> None:
        try:
            with Robot(self.line, idle_s=None) as self.robot:
                drive(self.robot)
        except (OmxError, KeyboardInterrupt) as error:
            self.error = error
        except Exception as error:
            raise Broken(f"it raised {error!r} after {self.told}") from error

    def _fell(self) -> bool:
        """Did a joint sink out of its limits, as the program was held up while its motor was off for its mode?"""
        return isinstance(self.error, OutOfBounds) and "held up" in self.name and "set_up" in self.spoilt

    def _end(self) -> str:
        """How it ended: the line is closed, the arm stands, and no motor is on, or off, without a word."""
        told, said = f"{self.told}: {self.error!r}", " ".join([str(self.error), *self.heard.lines])
        on = [servo for servo in JOINT_IDS if self.arm.servo(servo).torque_on and self.arm.servo(servo).powered]
        if self.error and self.name in HARMLESS and not self._fell():
            raise Broken(f"it ended early after {told}")
        if self.line.is_open:
            raise Broken(f"the line is open after {told}")
        if any(abs(self.arm.servo(servo).joint.speed) > 1e-3 for servo in on):
            raise Broken(f"the arm still moves after {told}")
        if self.error is None and on:
            raise Broken(f"the motors {on} are on without an error after {told}")
        if on and not ("MOTORS ARE ON" in said or "motors on" in said):
            raise Broken(f"the motors {on} stay on without a word after {told}")
        if len(on) < 4 and not self._may_be_limp(on, said):
            raise Broken(f"the motors {on} alone are on, and nobody switched the others off, after {told}")
        if not on and self.arm.servo(15).torque_on and "gripper" not in self.name and self.error is None:
            raise Broken(f"the gripper is left on after {told}")
        kind = type(self.error).__name__ if self.error else "done"
        return f"{kind}, {'holds' if len(on) == 4 else 'some limp' if on else 'motors off'}"

    def _may_be_limp(self, on, said: str) -> bool:
        rows = np.array(self.rows)
        lit = np.flatnonzero(rows[:, 5] > 0) if len(rows) else []
        if not len(lit):
            return True  # never on
        if self.name == "plug pulled" and len(on) == 3:
            return True  # in the moment in which that joint changed its mode
        parked = np.abs(rows[lit[-1], 2:5] - REST[1:]).max() < math.radians(8)
        return (parked and not on) or (self.name in LIMP and "servo" in said)

    def _again(self) -> None:
        """With the fault away, the next one who comes drives the arm, and parks it."""
        if self.error is None:
            return
        self.arm.faults.clear()
        self.arm.advance(self.arm.now + 1.0)
        for servo in self.arm.servos:
            if servo.table["hardware_error"]:
                servo.reboot(self.arm.time)
        self.arm.advance(self.arm.now + 1.0)
        self.stopped_at, self.rows = math.inf, []
        try:
            with Robot(VirtualPort(self.arm, SteppedClock()), idle_s=None) as self.robot:
                self.robot.write_motor_state(True)
        except OmxError as error:
            raise Broken(f"the next one met {error!r} after {self.told}") from error
        self.judge()
        if any(servo.torque_on for servo in self.arm.servos):
            raise Broken(f"the next one left motors on after {self.told}")


def drive(robot: Robot) -> None:
    """A little of everything, begun near the rest pose; it leaves the arm in mid-move."""
    robot.write_motor_state(True)
    robot.move_to(np.degrees(START) + np.array([8, 4, -4, 4]), 0.5)
    robot.arm.grip(30.0, 50.0)
    robot.grip(payload_g=50.0)
    aim = np.array(robot.driver.read().aim)
    for i in range(3):
        robot.driver.stream_to(aim + math.radians(i), 0.1)
        robot.clock.sleep(0.05)
    robot.write_mode("velocity")
    for _ in range(3):
        robot.write_velocities([20, 5, 0, 0])
        robot.clock.sleep(0.1)
    robot.write_mode("current")
    for _ in range(3):
        modes.balance(robot.driver)
        robot.clock.sleep(0.1)
    robot.write_mode("position")
    robot.get_joints_readings()
    robot.release()
    robot.write_time(1.0)
    robot.write_joints(np.degrees(START) + np.array([-15, 4, 4, 4]))
    robot.clock.sleep(0.3)


def packets() -> list[int]:
    """The packets of the programme, of each place in the code (with all that called it) the first and the last.

    What happens in between is the same question again, most of it while a loop waits for the arm.
    """
    whole = Sweep()
    whole.run()
    places = whole.line.places
    first = {place: k for k, place in reversed(list(enumerate(places, start=1)))}
    last = {place: k for k, place in enumerate(places, start=1)}
    return sorted({*first.values(), *last.values()})


def main(argv=None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.helpers.sweep", description=__doc__.splitlines()[0])
    parser.add_argument("--stride", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("names", nargs="*", help=f"some of: {', '.join(SPOILS)}")
    given = parser.parse_args(argv)
    began, some, broken = time.monotonic(), packets()[given.first :: given.stride], 0
    for name in given.names or SPOILS:
        ends = collections.Counter()
        for k in some:
            try:
                ends[Sweep(name, k).run()] += 1
            except Broken as error:
                broken += 1
                ends["BROKEN"] += 1
                print(f"  {error}", flush=True)
        print(f"{name}: {', '.join(f'{n} {end}' for end, n in ends.most_common())}", flush=True)
    print(
        f"{len(some)} packets, {len(given.names or SPOILS)} faults, {time.monotonic() - began:.0f} s: {broken} broken"
    )
    return int(bool(broken))


if __name__ == "__main__":
    sys.exit(main())
