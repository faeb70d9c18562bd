"""Servos in trouble: who is silent, who has lost its torque, and switching them on again where they stand."""

import contextlib

from ...errors import BusError, NotReady, PortLost, ServoLost, ServoRestarted
from ..dynamixel import registers as reg
from ..dynamixel.bus import again
from .servo_group import JOINTS, MODES, Servos

#: How long a servo that restarts is silent, and a little more.
RESTART_S = 0.6
LOOK_S = 0.02


class Rescue:
    """Looks after `servos`, of which `ids` are there. Whoever calls it has made the arm hold."""

    def __init__(self, servos: Servos, ids: list[int]):
        self.servos, self.bus, self.ids = servos, servos.bus, ids

    def find(self, error: BusError) -> None:
        """Wait for who did not answer, as long as a restart takes; raises `ServoLost` if that is not all of them."""
        gone, until = self.ids, self.bus.clock.now() + RESTART_S
        while True:
            there = self.bus.scan(gone)
            gone = [servo for servo in gone if servo not in there]
            if not gone:
                return
            if self.bus.clock.now() >= until:
                raise ServoLost(self.bus.name, "answer", gone, [s for s in self.ids if s not in gone]) from error
            self.bus.clock.sleep(LOOK_S)

    def off(self) -> list[int]:
        """The joints without torque."""
        return [servo for servo, on in self.servos.of_joints("torque_enable").items() if not on]

    def catch(self, servos) -> None:
        """Switch on again, where they stand, `servos` that have restarted; raises `ServoRestarted`."""
        caught = []
        for servo in servos:
            with contextlib.suppress(BusError):
                self.servos.set_up(servo)
                caught.append(servo)
        raise ServoRestarted(self.bus.name, servos, held=len(caught) == len(servos))

    def recover(self, torque: bool) -> list[int]:
        """Reboot each servo that reports an error; with `torque`, switch on what has none. Returns the rebooted."""
        bits = again(self.bus.read_all, self.ids, "hardware_error")
        faulty = [servo for servo in bits if bits[servo]]
        for servo in faulty:
            self.bus.reboot(servo)
            self.bus.clock.sleep(0.5)
            self.servos.set_up(servo)
        for servo in self.off() if torque else ():
            self.servos.set_up(servo)
        return faulty

    def check_settings(self) -> None:
        """Is every joint still as it was set up? After a restart, or another program, a goal would mean full speed."""
        wanted = (reg.DRIVE_TIME_BASED, reg.MODES["position"])
        found = again(self.bus.read_block, JOINTS, MODES)
        wrong = [
            f"servo {servo} has drive mode {got[0]} and operating mode {got[1]} instead of {wanted[0]} and "
            f"{wanted[1]}, so goals would not take the time given: `robot.write_motor_state(True)` sets it up"
            for servo, got in found.items()
            if got != wanted
        ]
        if wrong:
            raise NotReady(self.bus.name, wrong)


def port_lost(error: PortLost) -> PortLost:
    """The same, with what it means for the arm."""
    said = str(error).removeprefix(f"{error.port}: ")
    return PortLost(
        error.port,
        f"{said} The arm cannot hear us: it ends its last move by itself and holds there, motors on (the power switch "
        "is the emergency stop). With the plug back in, `robot.bus.reopen()` goes on.",
        error.errno,
    )
