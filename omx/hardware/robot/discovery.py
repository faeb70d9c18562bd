"""Finding the arm, and looking it over before anything moves: all that is wrong, in one message."""

import sys
from itertools import chain
from typing import NamedTuple

from ...arm import ARM_IDS, GRIPPER_ID, JOINT_IDS
from ...errors import NotReady, PortBusy, PortError
from ..dynamixel import web_serial
from ..dynamixel.bus import Bus
from ..dynamixel.sdk import is_open_here
from ..dynamixel.serial_line import find_ports
from ..fault_table import Finding, judge, sentences, settings


class ArmCondition(NamedTuple):
    """What one look over the arm found: the registers of each servo by name, and what there is to say."""

    registers: dict[int, dict[str, int]]
    found: list[Finding]
    warnings: list[str]


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


def look_over(bus: Bus) -> ArmCondition:
    """Ping every servo and read all that the rows judge; raises `NotReady` with all that is wrong. Reads only."""
    pings = bus.scan(ARM_IDS)
    if silent := [servo for servo in ARM_IDS if servo not in pings]:
        pings |= bus.scan(silent)  # an answer may get lost, or come late
    problems, warnings = [], []
    if missing := [servo for servo in JOINT_IDS if servo not in pings]:
        listed = ", ".join(map(str, missing))
        problems.append(
            f"no answer from servo {listed}: look at the cable to servo {missing[0]} and at the 12 V supply"
        )
    if GRIPPER_ID not in pings:
        warnings.append("no gripper: servo 15 does not answer")
    models = {servo: judge(servo, {"model_number": ping.model, "firmware_version": ping.firmware})
              for servo, ping in pings.items()}  # fmt: skip
    at, errors = settings(bus, [servo for servo in pings if not models[servo]])
    found = [*chain(*models.values()), *chain(*(judge(servo, at[servo]) for servo in at))]
    problems += [*map(str, errors), *sentences(one for one in found if one.forbids)]
    warnings += sentences(one for one in found if one.warns)
    if problems:
        raise NotReady(bus.name, problems)
    return ArmCondition(at, found, warnings)
