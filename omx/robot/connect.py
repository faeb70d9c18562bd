"""Finding the arm, and looking it over before anything moves: all that is wrong, in one message."""

from dataclasses import dataclass, field

from ..dynamixel import registers as reg
from ..dynamixel import units
from ..dynamixel.bus import Bus
from ..errors import BusError, OmxError, PortError

#: What each XM430 of the arm must at least be (time-based profiles came with firmware 42).
OLDEST_FIRMWARE = 42
WARN_VOLTS, FEWEST_VOLTS = 11.0, 10.0
WARN_DEGREES, MOST_DEGREES = 60, 70

#: USB adapters that the arm is sold with: U2D2 (FTDI) and OpenCR, by vendor and product id.
ADAPTERS = {(0x0403, 0x6014): "U2D2", (0x0403, 0x6001): "USB serial (FTDI)", (0xFFF1, 0xFF48): "OpenCR",
            (0x0483, 0x5740): "OpenCR"}  # fmt: skip


class NotReady(OmxError):
    """The arm cannot be used as it is: `problems` lists everything that was found, not only the first."""

    def __init__(self, where: str, problems: list[str]):
        self.problems = list(problems)
        listed = "\n".join(f"  - {problem}" for problem in self.problems)
        super().__init__(f"{where} is not ready:\n{listed}\n`python run.py doctor` looks further.")


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
        return reg.GRIPPER_ID in self.servos


def find_ports() -> list[str]:
    """Serial ports that may have the arm, likely adapters first."""
    from serial.tools import list_ports

    ports = [port for port in list_ports.comports() if port.vid is not None]
    ports.sort(key=lambda port: ((port.vid, port.pid) not in ADAPTERS, port.device))
    return [port.device for port in ports]


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
        if bus.scan(reg.JOINT_IDS):
            return bus
        bus.close()
        tried.append(f"{port}: no servo of the arm answers at 1000000 baud")
    found = "; ".join(tried) or "this computer has no USB serial port: is the cable in, and the adapter's driver there?"
    raise PortError("auto", f"no arm found. {found}")


def look_over(bus: Bus) -> Condition:
    """Ping every servo and read model, firmware, errors, voltage and temperature. Reads only; nothing moves."""
    condition = Condition(servos=bus.scan(reg.ARM_IDS))
    missing = [servo for servo in reg.JOINT_IDS if servo not in condition.servos]
    if missing:
        listed = ", ".join(map(str, missing))
        condition.problems.append(
            f"no answer from servo {listed}: look at the cable to servo {missing[0]} and at the 12 V supply"
        )
    if not condition.has_gripper:
        condition.warnings.append("no gripper: servo 15 does not answer")
    for servo, ping in condition.servos.items():
        if ping.model != reg.MODEL_XM430_W350:
            condition.problems.append(f"servo {servo} is model {ping.model}, not {reg.MODEL_XM430_W350} (XM430-W350)")
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
