"""Endurance: gripping, carrying, logging and dragging sliders, for as long as you say, in one process.

    python -m tests.helpers.endurance --minutes 30

Prints, a line a minute and once at the end: samples taken and missed, how late the loop ran, how far the arm ended
from where it was sent (drift), what was gripped and lost, how warm the servos got, and how the memory grew. Exits with
1 if a sample was missed, something was lost, or something grew.
"""

import argparse
import gc
import math
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import psutil

from omx.arm import ARM_IDS
from omx.hardware.log import Recorder, read_log
from omx.hardware.robot import Robot
from omx.hardware.robot.robot import COLUMNS
from omx.hardware.simulator import Clock

RATE = 50.0
#: Where a round goes, in degrees; then a stream of small steps, as a slider sends them, and back.
ROUND = ([30, -40, 10, 30], [-45, -20, -10, 40], [0, -60, 20, 40])
MOVE_S, DRAG_S = 2.0, 4.0
#: What is carried on every round: as wide (mm) and as heavy (g).
WIDTH, GRAMS = 30.0, 250.0
#: The longest step of a slider: what the speed cap allows in the time of a step, and a little less.
LONGEST = math.radians(2.5)
#: How much of the swing each slider takes.
AXES = np.array([1, 1 / 3, 0, 0])
#: What may grow, for it was asked for, in bytes a sample: the log's 17 floats and their tuple, and one float in `late`.
#: Python's allocator gives a float 32 bytes, and the tuple 192 with its place in the list.
SAMPLE_BYTES = 17 * 32 + 192 + 32 + 9


@dataclass
class Findings:
    """What was seen: times in s, angles in deg, memory in bytes."""

    asked: int = 0
    taken: int = 0
    late: list[float] = field(default_factory=list)
    home: list[np.ndarray] = field(default_factory=list)
    memory: list[int] = field(default_factory=list)
    drags: int = 0
    gripped: int = 0
    carried: int = 0
    degrees: int = 0

    @property
    def missed(self) -> int:
        """Samples that were due and not taken."""
        return self.asked - self.taken

    @property
    def drift(self) -> float:
        """The difference (deg) between the last and the first end of a round, for the joint where it is greatest."""
        return float(np.abs(self.home[-1] - self.home[0]).max())

    @property
    def growth(self) -> int:
        """Bytes that the process grew by since its first round, less what the samples themselves take.

        Below 2 MB is none: the allocator's pages, and caches that fill up once.
        """
        return self.memory[-1] - self.memory[0]

    def __str__(self) -> str:
        late = np.array(self.late) * 1000
        return (
            f"{self.taken} samples, {self.missed} missed; late: median {np.median(late):.2f} ms, 99.9 % "
            f"{np.quantile(late, 0.999):.1f} ms, most {late.max():.1f} ms; {self.drags} slider steps; "
            f"{self.carried} of {self.gripped} objects carried, servos at most {self.degrees} degC; drift "
            f"{self.drift:.3f} deg in {len(self.home)} rounds; memory {self.memory[-1] / 1e6:.1f} MB, "
            f"{self.growth / 1e6:+.2f} MB since the first round"
        )


def endure(seconds: float, path: Path, clock=None, tell=lambda findings, share: None) -> Findings:
    """Rounds of moves and drags for `seconds` of the arm's time, every sample logged to `path`."""
    found, robot = Findings(), Robot(clock=clock)
    start = robot.clock.now()
    with Recorder(path, COLUMNS) as recorder:
        robot.write_motor_state(True)
        while not found.home or robot.clock.now() - start < seconds:
            robot.release()
            robot.arm.grip(WIDTH, GRAMS)
            found.gripped += robot.grip(payload_g=GRAMS).holding
            for goal in ROUND:
                robot.write_time(MOVE_S)
                robot.write_joints(goal)
                _sampled(robot, recorder, found, MOVE_S + 0.2, lambda t: None)
            _sampled(robot, recorder, found, DRAG_S, _dragging(robot, found))
            found.carried += robot.holding and robot.arm.grasped.carried
            found.degrees = max(found.degrees, *robot.bus.read_all(ARM_IDS, "present_temperature").values())
            robot.move_to(ROUND[-1])
            found.home.append(np.array(robot.get_joints_readings()[0]))
            gc.collect()
            found.memory.append(psutil.Process().memory_info().rss - SAMPLE_BYTES * len(recorder.log))
            tell(found, min((robot.clock.now() - start) / seconds, 1.0))
    robot.release()
    robot.park()
    robot.close()
    return found


def _dragging(robot, found: Findings):
    """A hand on two sliders: at every tick a small step from the one before, however long the computer was busy."""
    home = np.radians(ROUND[-1])
    sent = np.array(robot.driver.read().aim)

    def drag(t: float) -> None:
        nonlocal sent
        wanted = home + math.radians(15) * math.sin(math.tau * t / DRAG_S) * AXES
        step = sent + np.clip(wanted - sent, -LONGEST, LONGEST)
        here = np.array(robot.driver.read().q)  # a computer that was busy catches up, the arm does not leap
        sent = np.clip(step, here - 2 * LONGEST, here + 2 * LONGEST)
        robot.driver.stream_to(sent, 2.5 / RATE)
        found.drags += 1

    return drag


def _sampled(robot, recorder: Recorder, found: Findings, seconds: float, each) -> None:
    found.asked += math.floor(seconds * RATE + 1e-9) + 1
    for i, t in enumerate(robot.ticks(seconds, RATE)):
        each(t)
        robot._sample(recorder, robot.driver.watch(), t)
        found.taken += 1
        found.late.append(t - i / RATE)
    robot.driver.wait()


def main(argv=None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.helpers.endurance", description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--scale", type=float, default=1.0, help="how many times as fast as real time")
    given = parser.parse_args(argv)
    told = [time.monotonic()]

    def tell(found: Findings, share: float) -> None:
        if time.monotonic() - told[0] > 60:
            told[0] = time.monotonic()
            print(f"{share:4.0%}  {found}", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        found = endure(60 * given.minutes, Path(folder) / "endurance.csv", Clock(given.scale), tell)
        again = len(read_log(Path(folder) / "endurance.csv"))
    print(f"{found}\n{again} samples read back from the disk")
    lost = not found.carried == found.gripped == len(found.home)
    return int(found.missed != 0 or again != found.taken or lost or found.drift > 0.3 or found.growth > 2e6)


if __name__ == "__main__":
    sys.exit(main())
