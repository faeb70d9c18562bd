"""Servos in trouble: who is silent, who has lost its torque, and switching them on again where they stand.

Whoever calls this has made the arm hold.
"""

import contextlib

from ...errors import BusError, NotReady, PortLost, ServoLost, ServoRestarted
from ..dynamixel import registers as reg
from ..dynamixel.bus import again
from .servo_group import JOINTS, MODES, Servos

#: How long a servo that restarts is silent, and a little more.
RESTART_S = 0.6
LOOK_S = 0.02


def find(servos: Servos, error: BusError) -> None:
    """Wait for who did not answer, as long as a restart takes; raises `ServoLost` if that is not all of them."""
    bus, gone = servos.bus, servos.ids
    until = bus.clock.now() + RESTART_S
    while True:
        there = bus.scan(gone)
        gone = [servo for servo in gone if servo not in there]
        if not gone:
            return
        if bus.clock.now() >= until:
            raise ServoLost(bus.name, "answer", gone, [s for s in servos.ids if s not in gone]) from error
        bus.clock.sleep(LOOK_S)


def off(servos: Servos) -> list[int]:
    """The joints without torque."""
    return [servo for servo, on in servos.of_joints("torque_enable").items() if not on]


def catch(servos: Servos, restarted) -> None:
    """Switch on again, where they stand, those that have `restarted`; raises `ServoRestarted`."""
    caught = []
    for servo in restarted:
        with contextlib.suppress(BusError):
            servos.set_up(servo)
            caught.append(servo)
    raise ServoRestarted(servos.bus.name, restarted, held=len(caught) == len(restarted))


def recover(servos: Servos, torque: bool) -> list[int]:
    """Reboot each servo that reports an error; with `torque`, switch on what has none. Returns the rebooted."""
    bits = again(servos.bus.read_all, servos.ids, "hardware_error")
    faulty = [servo for servo in bits if bits[servo]]
    for servo in faulty:
        servos.bus.reboot(servo)
        servos.bus.clock.sleep(0.5)
        servos.set_up(servo)
    for servo in off(servos) if torque else ():
        servos.set_up(servo)
    return faulty


def check_settings(servos: Servos) -> None:
    """Is every joint still as it was set up? After a restart, or another program, a goal would mean full speed."""
    wanted = (reg.DRIVE_TIME_BASED, reg.MODES["position"])
    found = again(servos.bus.read_block, JOINTS, MODES)
    wrong = [
        f"servo {servo} has drive mode {got[0]} and operating mode {got[1]} instead of {wanted[0]} and "
        f"{wanted[1]}, so goals would not take the time given: `robot.write_motor_state(True)` sets it up"
        for servo, got in found.items()
        if got != wanted
    ]
    if wrong:
        raise NotReady(servos.bus.name, wrong)


def port_lost(error: PortLost) -> PortLost:
    """The same, with what it means for the arm."""
    said = str(error).removeprefix(f"{error.port}: ")
    return PortLost(
        error.port,
        f"{said} The arm cannot hear us: it ends its last move by itself and holds there, motors on (the power switch "
        "is the emergency stop). With the plug back in, `robot.bus.reopen()` goes on.",
        error.errno,
    )
