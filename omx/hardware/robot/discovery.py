"""Finding the arm, and looking it over before anything moves: all that is wrong, in one message."""

from dataclasses import dataclass, field

from ...arm import (
    ARM_IDS,
    FEWEST_VOLTS,
    GRIPPER_ID,
    JOINT_IDS,
    MODEL,
    MOST_DEGREES,
    OLDEST_FIRMWARE,
    WARN_DEGREES,
    WARN_VOLTS,
)
from ...errors import BusError, PortError
from ..dynamixel import registers as reg
from ..dynamixel import units
from ..dynamixel.bus import Bus
from ..dynamixel.serial_line import find_ports


@dataclass
class Condition:
    """What one look over the arm found. `problems` forbid using it, `warnings` do not."""

    servos: dict[int, reg.Register] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    volts: dict[int, float] = field(default_factory=dict)
    degrees: dict[int, float] = field(default_factory=dict)

    @property
    def has_gripper(self) -> bool:
        return GRIPPER_ID in self.servos


def open_bus(name: str) -> Bus:
    """The bus on the port `name`; "auto" takes the first port on which servo 11 answers. Raises `PortError`."""
    if name != "auto":
        return Bus(name)
    tried = []
    for port in find_ports():
        try:
            bus = Bus(port)
        except PortError as error:
            tried.append(str(error))
            continue
        if bus.scan(JOINT_IDS):
            return bus
        bus.close()
        tried.append(f"{port}: no servo of the arm answers at 1000000 baud")
    found = "; ".join(tried) or "this computer has no USB serial port: is the cable in, and the adapter's driver there?"
    raise PortError("auto", f"no arm found. {found}")


def look_over(bus: Bus) -> Condition:
    """Ping every servo and read model, firmware, errors, voltage and temperature. Reads only; nothing moves."""
    condition = Condition(servos=bus.scan(ARM_IDS))
    missing = [servo for servo in JOINT_IDS if servo not in condition.servos]
    if missing:
        listed = ", ".join(map(str, missing))
        condition.problems.append(
            f"no answer from servo {listed}: look at the cable to servo {missing[0]} and at the 12 V supply"
        )
    if not condition.has_gripper:
        condition.warnings.append("no gripper: servo 15 does not answer")
    for servo, ping in condition.servos.items():
        if ping.model != MODEL:
            condition.problems.append(f"servo {servo} is model {ping.model}, not {MODEL} (XM430-W350)")
        elif ping.firmware < OLDEST_FIRMWARE:
            condition.problems.append(f"servo {servo} has firmware {ping.firmware}; {OLDEST_FIRMWARE} is needed")
        else:
            _health(bus, servo, condition)
    return condition


def _health(bus: Bus, servo: int, condition: Condition) -> None:
    try:
        bits = bus.read(servo, "hardware_error")
        volts = units.VOLTAGE.value(bus.read(servo, "present_voltage"))
        degrees = bus.read(servo, "present_temperature")
    except BusError as error:
        condition.problems.append(str(error))
        return
    condition.volts[servo], condition.degrees[servo] = volts, degrees
    if bits:
        words = ", ".join(reg.hardware_errors(bits))
        condition.problems.append(f"servo {servo} reports: {words}. Remove the cause, then `robot.recover()`")
    judge(servo, volts, degrees, condition)


def judge(servo: int, volts: float, degrees: float, condition: Condition) -> None:
    """Voltage and temperature of one servo against the limits, into `condition`."""
    if volts < FEWEST_VOLTS:
        condition.problems.append(f"servo {servo} has {volts:.1f} V; it needs 12 V, at least {FEWEST_VOLTS:.0f}")
    elif volts < WARN_VOLTS:
        condition.warnings.append(f"servo {servo} has only {volts:.1f} V: is the supply the arm's own, 12 V 5 A?")
    if degrees >= MOST_DEGREES:
        condition.problems.append(f"servo {servo} is at {degrees:.0f} degrees C: let it cool down")
    elif degrees >= WARN_DEGREES:
        condition.warnings.append(f"servo {servo} is warm: {degrees:.0f} degrees C")
