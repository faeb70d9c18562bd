"""What can stop a motion, by name. Whatever it is, the arm holds: each message says so and names the cause."""

from ..errors import BusError, BusTimeout, OmxError, PortLost

HOLDS = "The arm holds."


class Stopped(OmxError):
    """The stop button was pressed; the arm holds. `resume()` allows commands again."""

    def __init__(self):
        super().__init__("stopped: the arm holds. `robot.resume()` allows commands again.")


class TorqueOff(OmxError):
    """The motors are off, so there is nothing to command."""

    def __init__(self):
        super().__init__("the motors are off. `robot.write_motor_state(True)` switches them on where the arm stands.")


class Stalled(OmxError):
    """A joint pushes and does not move. `joint` is 1 .. 4, `current` in mA; the arm holds."""

    def __init__(self, joint: int, current: float):
        self.joint, self.current = joint, current
        super().__init__(
            f"joint {joint} is pushing on something ({abs(current):.0f} mA) and does not move. {HOLDS} "
            "Take away what is in its way, then move on."
        )


class ServoLost(BusTimeout):
    """Servos that answered before have gone for good: `missing`; `answered` are still there, and hold."""

    def __init__(self, port: str, doing: str, missing, answered):
        self.doing, self.missing, self.answered = doing, tuple(missing), tuple(answered)
        BusError.__init__(self, port, f"{_gone(self.missing, self.answered)} `python run.py doctor` looks further.")


class ServoRestarted(BusError):
    """Servos restarted by themselves and lost their torque: `servos`; `held` says whether they hold again."""

    def __init__(self, port: str, servos, held: bool):
        self.servos, self.held = tuple(servos), held
        now = f"It was switched on again where it was. {HOLDS}" if held else "Its motor is OFF: support the arm."
        super().__init__(
            port,
            f"servo {_listed(self.servos)} restarted by itself, and its motor went off for a moment: too little power, "
            f"or a loose plug. {now} Look at the supply and the cables, then move on.",
        )


def _gone(missing, answered) -> str:
    if not answered:
        return "no servo answers any more: the 12 V supply is off (then the arm falls), or the first cable is out."
    if len(missing) > 1 and min(missing) > max(answered):
        where = f"the chain is broken between servo {max(answered)} and servo {missing[0]}: look at that cable"
        return f"servo {_listed(missing)} no longer answer; {where}. The others hold; these may have no power."
    return f"servo {_listed(missing)} no longer answers: look at its cable. The others hold; it may have no power."


def port_lost(error: PortLost) -> PortLost:
    """The same, with what it means for the arm."""
    said = str(error).removeprefix(f"{error.port}: ")
    return PortLost(
        error.port,
        f"{said} The arm cannot hear us: it ends its last move by itself and holds there, motors on (the power switch "
        "is the emergency stop). With the plug back in, `robot.bus.reopen()` goes on.",
        error.errno,
    )


def _listed(ids) -> str:
    return ", ".join(map(str, ids))
