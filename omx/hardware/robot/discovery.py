"""Finding the arm, and looking it over before anything moves: all that is wrong, in one message."""

import sys
from dataclasses import dataclass, field

from ...arm import ARM_IDS, GRIPPER_ID, JOINT_IDS
from ...errors import BusError, PortBusy, PortError
from ..dynamixel import web_serial
from ..dynamixel.bus import Bus, Ping
from ..dynamixel.sdk import is_open_here
from ..dynamixel.serial_line import find_ports
from ..fault_table import Finding, judge, registers, sentences


@dataclass
class Condition:
    """What one look over the arm found. `problems` forbid using it, `warnings` do not."""

    servos: dict[int, Ping] = field(default_factory=dict)
    registers: dict[int, dict[str, int]] = field(default_factory=dict)
    found: list[Finding] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    @property
    def has_gripper(self) -> bool:
        return GRIPPER_ID in self.servos

    @property
    def left_behind(self) -> list[str]:
        """What other programs left in the servos, and switching the motors on sets back."""
        return [one.symptom for one in self.found if one.mended and one.level != "note"]


def open_bus(name: str) -> Bus:
    """The bus on the port `name`; "auto" looks at the adapters that arms are sold with, and wants exactly one arm."""
    return _search() if name == "auto" else _opened(name)


def _opened(name: str) -> Bus:
    try:
        return Bus(name)
    except PortBusy as error:
        if is_open_here(name):
            said = "this very notebook has it open: go on with that robot, or end it with `robot.close()`"
            raise PortBusy(name, said, error.errno) from error
        raise


def _search() -> Bus:
    """The one adapter with an arm. Nothing is sent to other devices, nor to an arm if there are two."""
    tried, arms = [], []
    adapters = find_ports(adapters_only=True)
    for port in adapters:
        try:
            bus = _opened(port)
        except PortError as error:
            tried.append(str(error))
            continue
        if bus.scan(JOINT_IDS):
            arms.append(bus)
        else:
            bus.close()
            tried.append(f"{port}: no servo of the arm answers at 1000000 baud")
    if len(arms) == 1:
        return arms[0]
    for bus in arms:
        bus.close()
    if arms:
        raise PortError("auto", f"there are {len(arms)} arms: {' and '.join(bus.name for bus in arms)}. Name yours: "
                                f"`Robot({arms[0].name!r})`.")  # fmt: skip
    tried += [f"{port}: not asked, for it does not look like the arm's adapter; name it if it is"
              for port in find_ports() if port not in adapters]  # fmt: skip
    nothing = "this computer has no USB serial port: is the cable in, and the adapter's driver there?"
    if sys.platform == "emscripten":
        nothing = f"none is connected to this page: {web_serial.HOW}"
    found = "; ".join(tried) or nothing
    raise PortError("auto", f"no arm found. {found}")


def look_over(bus: Bus) -> Condition:
    """Ping every servo and read all that the conditions judge. Reads only; nothing moves."""
    condition = Condition(servos=bus.scan(ARM_IDS))
    if silent := [servo for servo in ARM_IDS if servo not in condition.servos]:
        condition.servos |= bus.scan(silent)  # an answer may get lost, or come late
    missing = [servo for servo in JOINT_IDS if servo not in condition.servos]
    if missing:
        listed = ", ".join(map(str, missing))
        condition.problems.append(
            f"no answer from servo {listed}: look at the cable to servo {missing[0]} and at the 12 V supply"
        )
    if not condition.has_gripper:
        condition.warnings.append("no gripper: servo 15 does not answer")
    right = []
    for servo, ping in condition.servos.items():
        found = judge(servo, {"model_number": ping.model, "firmware_version": ping.firmware})
        condition.found += found
        right += [servo] if not found else []
    if right:
        _settings(bus, right, condition)
    condition.problems += sentences(one for one in condition.found if one.forbids)
    condition.warnings += sentences(one for one in condition.found if one.warns)
    return condition


def _settings(bus: Bus, servos, condition: Condition) -> None:
    try:
        condition.registers = registers(bus, servos)
    except BusError:  # one of them does not answer: which?
        for servo in servos:
            try:
                condition.registers |= registers(bus, [servo])
            except BusError as error:
                condition.problems.append(str(error))
    for servo, at in condition.registers.items():
        condition.found += judge(servo, at)
