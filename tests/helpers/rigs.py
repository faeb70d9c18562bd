"""Rigs that tests share: a bus to a virtual arm on a clock that moves only when slept on."""

import sys
from contextlib import contextmanager

from omx.arm import ARM_IDS, JOINT_IDS
from omx.hardware.dynamixel import units
from omx.hardware.dynamixel.bus import Bus
from omx.hardware.dynamixel.packet import Reader
from omx.hardware.dynamixel.registers import MODES
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort

#: A pseudo-terminal takes the servos' rate on Linux; on macOS it takes none above this.
PTY_BAUD = 115_200 if sys.platform == "darwin" else 1_000_000


@contextmanager
def rig(timed=False, latency_s=0.0, **arm):
    """(bus, arm, clock): a fresh arm and a bus to it in stepped time."""
    virtual, clock = VirtualArm(**arm), SteppedClock()
    with Bus(VirtualPort(virtual, clock, timed=timed, latency_s=latency_s)) as bus:
        yield bus, virtual, clock


def parse(frame):
    """The first packet in `frame`, or None."""
    return next(iter(Reader().feed(frame)), None)


def stiffen(bus, seconds=1.0, mode="position", ids=ARM_IDS):
    """Time-based profile, goal at the present position, torque on."""
    for servo in ids:
        bus.write(servo, "torque_enable", 0)
        bus.write(servo, "drive_mode", 4)
        bus.write(servo, "operating_mode", MODES[mode])
        bus.write(servo, "profile_velocity", round(1000 * seconds))
        bus.write(servo, "profile_acceleration", round(250 * seconds))
        bus.write(servo, "goal_position", bus.read(servo, "present_position"))
        bus.write(servo, "torque_enable", 1)


def send_to(bus, q, ids=JOINT_IDS):
    """Goal positions (rad) for the joints, in one packet."""
    goals = {servo: units.POSITION.raw(float(angle)) for servo, angle in zip(ids, q, strict=True)}
    bus.write_all("goal_position", goals)
    return goals
