"""Faults to order: what can go wrong with an arm, as rows of data.

    arm.faults.inject("lost", servo=13, count=2)
    arm.faults.inject("overload", servo=12, after=0.5)

Some faults spoil the frames on the wire; the others happen to a servo, or to the arm as a whole.
"""

import random
from collections.abc import Callable
from dataclasses import dataclass
from math import inf, radians
from typing import NamedTuple

from ...arm import ARM_IDS
from ...arrays import as_number
from ...errors import BadInput
from ..dynamixel import registers as reg


@dataclass
class Fault:
    """One fault at work: `kind` names a row of KINDS, which says what `value` is; `servo` is 11 .. 15 or None.

    A fault of the wire skips the first `after` frames and spoils the next `count`; `servo` None means any servo's.
    Any other fault begins `after` s from now.
    """

    kind: str
    servo: int | None = None
    count: float = inf
    after: float = 0.0
    value: float | None = None
    undo: Callable[[], None] | None = None


class Faults:
    """The faults of one arm. The same injections spoil the same bytes each time."""

    def __init__(self, arm):
        self._arm = arm
        self._on_wire: list[Fault] = []
        self._begun: list[Fault] = []
        self._random = random.Random(0)

    @property
    def active(self) -> list[Fault]:
        """The faults that are at work now."""
        return [*self._on_wire, *self._begun]

    def inject(self, kind: str, servo: int | None = None, count: float = inf, after: float = 0.0, value=None) -> Fault:
        """Let a fault happen. The names are in `KINDS`, as is the `value` that each takes if none is given."""
        if kind not in KINDS:
            raise BadInput(f"No fault is called {kind!r}. There are: {', '.join(KINDS)}.")
        self._arm.catch_up()
        row = KINDS[kind]
        if row.of == "servo" or servo is not None:
            self._arm.servo(servo)
        fault = Fault(kind, servo, count, after, row.value if value is None else as_number(value, "value"))
        if row.of == "wire":
            self._on_wire.append(fault)
        elif after:
            self._arm.at(self._arm.now + after, lambda: self._begin(fault))
        else:
            self._begin(fault)
        return fault

    def inject_text(self, text: str) -> Fault:
        """`inject` from words, such as `lost servo=13 count=2`."""
        kind, *options = text.split() or [""]
        types = {"servo": int, "count": float, "after": float, "value": float}
        try:
            given = {name: types[name](number) for name, number in (option.split("=") for option in options)}
        except (KeyError, ValueError):
            form = "KIND servo=13 count=2 after=0.5 value=1"
            raise BadInput(
                f"A fault is written `{form}`, and all but the kind may be left out; got {text!r}."
            ) from None
        return self.inject(kind, **given)

    def _begin(self, fault: Fault):
        fault.undo = KINDS[fault.kind].do(self._arm, fault)
        self._begun.append(fault)
        self._arm.disturb()

    def clear(self):
        """End the faults. A hardware error stays until the servo is rebooted, as in life."""
        self._arm.catch_up()
        for fault in reversed(self._begun):
            if fault.undo:
                fault.undo()
        self._begun.clear()
        self._on_wire.clear()
        self._arm.disturb()

    def distort(self, frames):
        """What the faults of the wire leave of these frames."""
        for fault in list(self._on_wire):
            frames = [left for frame in frames for left in self._spoil(fault, frame)]
            if fault.count <= 0:
                self._on_wire.remove(fault)
        return frames

    def _spoil(self, fault: Fault, frame) -> list:
        spared = fault.servo is not None and frame.servo != self._arm.servo(fault.servo).id
        if spared or fault.count <= 0:
            return [frame]
        if fault.after >= 1:
            fault.after -= 1
            return [frame]
        fault.count -= 1
        return KINDS[fault.kind].do(frame, fault, self._random)


# ---- on the wire: one frame becomes any number of frames ----


def _corrupt(frame, fault, rng):
    data = bytearray(frame.data)
    data[rng.randrange(4, len(data))] ^= 1 << rng.randrange(8)
    return [frame._replace(data=bytes(data))]


# ---- of a servo, or of the arm: each does it and returns what undoes it, if anything can ----


def _register(name: str):
    def do(arm, fault):
        table = arm.servo(fault.servo).table
        before = table[name]
        table.put(name, int(fault.value))
        return lambda: table.put(name, before)

    return do


def _property(name: str):
    def do(arm, fault):
        owner = arm.servo(fault.servo) if KINDS[fault.kind].of == "servo" else arm
        before = getattr(owner, name)
        setattr(owner, name, fault.value)
        return lambda: setattr(owner, name, before)

    return do


def _unplugged(arm, _):
    arm.plugged = False
    return lambda: setattr(arm, "plugged", True)


def _hardware(bits: int):
    return lambda arm, fault: arm.servo(fault.servo).fail(bits)


def _unpowered(which: Callable):
    def do(arm, fault):
        servos = [s for built_as, s in zip(ARM_IDS, arm.servos, strict=True) if which(built_as, fault.servo)]
        for servo in servos:
            servo.powered = False
        return lambda: [servo.power_up(arm.time) for servo in servos]

    return do


def _blocked(arm, fault):
    joint = arm.joints[ARM_IDS.index(fault.servo)]
    before, slack = (joint.low, joint.high), abs(fault.value)
    joint.stops(joint.angle - slack, joint.angle + slack)
    return lambda: joint.stops(*before)


def _horn(arm, fault):
    servo = arm.servo(fault.servo)
    servo.mount = fault.value
    servo.wrap()
    return lambda: setattr(servo, "mount", 0.0)


class Kind(NamedTuple):
    """Of what a fault is, "wire", "servo" or "arm"; in words; what does it; the value it takes if none is given."""

    of: str
    text: str
    do: Callable
    value: float | None = None


KINDS = {
    "lost": Kind("wire", "a frame does not arrive", lambda frame, fault, rng: []),
    "corrupt": Kind("wire", "one bit of a frame is flipped", _corrupt),
    "truncated": Kind("wire", "the last `value` bytes of a frame are missing",
                      lambda frame, fault, rng: [frame._replace(data=frame.data[: -int(fault.value)])], 3),
    "duplicated": Kind("wire", "a frame arrives twice", lambda frame, fault, rng: [frame, frame]),
    "late": Kind("wire", "a frame arrives `value` s late",
                 lambda frame, fault, rng: [frame._replace(delay=fault.value, late=True)], 0.05),
    "noise": Kind("wire", "`value` random bytes before a frame",
                  lambda frame, fault, rng: [frame._replace(data=rng.randbytes(int(fault.value)) + frame.data)], 7),
    "dead": Kind("servo", "the servo is silent and limp", _unpowered(lambda one, it: one == it)),
    "broken_chain": Kind("servo", "this servo and all after it have no cable", _unpowered(lambda one, it: one >= it)),
    "no_power": Kind("arm", "the 12 V supply is off", _unpowered(lambda one, it: True)),
    "unplugged": Kind("arm", "the USB plug is pulled", _unplugged),
    "wrong_baud": Kind("servo", "the servo listens at the baud rate with code `value`", _register("baud_rate"), 1),
    "wrong_model": Kind("servo", "another servo is built in: model number `value`", _register("model_number"), 1060),
    "old_firmware": Kind("servo", "the servo has firmware `value`", _register("firmware_version"), 36),
    "wrong_id": Kind("servo", "the servo's id is `value`: 1 as from the factory, or another's", _register("id"), 1),
    "drive_mode": Kind("servo", "drive mode `value`, in the EEPROM: 5 inverts the gripper", _register("drive_mode"), 5),
    "slow_answer": Kind("servo", "return delay `value` x 2 us, on a timed wire", _register("return_delay_time"), 250),
    "silent": Kind("servo", "status return level `value`: 0 answers pings only", _register("status_return_level"), 0),
    "horn": Kind("servo", "the horn is screwed on `value` rad off", _horn, radians(90)),
    "blocked": Kind("servo", "something holds the joint; it can move `value` rad", _blocked, 0.0),
    "hot": Kind("servo", "the servo is at `value` degC", _property("temperature"), 75.0),
    "overload": Kind("servo", "hardware error: overload", _hardware(reg.OVERLOAD)),
    "shock": Kind("servo", "hardware error: electrical shock", _hardware(reg.SHOCK)),
    "encoder": Kind("servo", "hardware error: encoder", _hardware(reg.ENCODER)),
    "overheated": Kind("servo", "hardware error: overheated", _hardware(reg.OVERHEATED)),
    "reboots": Kind("servo", "it restarts by itself", lambda arm, fault: arm.servo(fault.servo).reboot(arm.time)),
    "low_voltage": Kind("arm", "the supply gives `value` V", _property("supply"), 9.0),
}  # fmt: skip
