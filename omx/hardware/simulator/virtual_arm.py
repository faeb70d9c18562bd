"""The virtual arm: five joints that feel gravity, the servos that turn them, and the passing of time.

Time passes only when someone asks: `advance(now)` computes what has happened since. The state is stepped on a
fixed grid that begins at 0, so it does not depend on how often anyone asked.
"""

import threading
from math import ceil, degrees, inf, pi, radians

from ...arm import ARM_IDS, FINGER_PER_RAD, FINGERS, GRIP_TORQUE_PER_N, HOME, OPENING_AT_ZERO, STOPS, SUPPLY_VOLTS
from ...arrays import as_number
from ...errors import BadInput
from .. import gravity
from ..dynamixel import registers as reg
from .faults import Faults
from .joint import Encoder, Joint
from .objects import Grasped
from .servo import Servo
from .world import EVERY

STEP_S = 0.002
#: No two arms have their stops at the same angles: at the start a joint may be this far (rad) beyond them.
STOP_SLACK = radians(6.0)
#: The servos look at their thermometers every so many steps.
THERMOMETER = 500
SUPPLY_OHMS, STANDBY_MA = 0.15, 40.0


class VirtualArm:
    """An OpenMANIPULATOR-X that was set up as the maker ships it: ids 11 .. 15 at 1 Mbps, all else factory-fresh.

    `q` is where the joints are (rad); `settings` changes registers, `{11: {"drive_mode": 4}}`, before power-on.
    An arm whose torque has never been on is held up by a hand, so it stays where it was put; after that it
    falls whenever its torque is off.

    The arm is ideal unless asked otherwise. `payload_g`: a mass at the tool, up to the maker's 500 g. `backlash_deg`:
    play of each joint from end to end, 0.25 deg by the servo's data sheet; the worse case is taken, that the encoder
    does not see it. `encoder_ripple_deg`, `encoder_noise_deg`: see `Encoder`.
    """

    def __init__(
        self,
        q=HOME,
        gripper: float = 0.0,
        settings: dict[int, dict[str, int]] | None = None,
        *,
        payload_g: float = 0.0,
        backlash_deg: float = 0.0,
        encoder_ripple_deg: float = 0.0,
        encoder_noise_deg: float = 0.0,
    ):
        angles = _angles(q)
        self.payload_g = gravity.payload(payload_g)
        play, ripple = _few(backlash_deg, "backlash_deg"), _few(encoder_ripple_deg, "encoder_ripple_deg")
        noise = _few(encoder_noise_deg, "encoder_noise_deg")
        self.joints = [Joint(angle, *stop, play=play) for angle, stop in zip(angles, STOPS, strict=True)]
        stops = sorted(finger / FINGER_PER_RAD for finger in FINGERS)
        self.joints.append(Joint(float(gripper), *stops, light=True))
        self.servos = [Servo(joint, servo) for joint, servo in zip(self.joints, ARM_IDS, strict=True)]
        for i, servo in enumerate(self.servos):
            servo.encoder = Encoder(ripple, i * pi / 3, noise)  # each magnet sits a little differently
            servo.wrap()
            servo.table.put("goal_position", servo.present())
        self.supply = SUPPLY_VOLTS
        self.lock = threading.RLock()
        self.plugged = True
        self.now = self.time = 0.0  # `time`: of the last step, to which the joints' angles belong (s)
        self._between: Grasped | None = None
        self.world = None  # a `World` makes itself known here
        self._hand = (0.0,) * 5
        self._connected = None
        self.faults = Faults(self)
        self._steps = 0
        self._events: list[tuple[float, object]] = []
        for servo_id, registers in (settings or {}).items():
            servo = self.servo(servo_id)
            for name, value in registers.items():
                servo.set(reg.register(name).name, value)
            servo.start(0.0)
        self._settle()

    def servo(self, servo_id: int) -> Servo:
        """The servo that was built in as `servo_id` (11 .. 15), whatever its id register says now."""
        if servo_id not in ARM_IDS:
            raise BadInput(f"The arm has servos {', '.join(map(str, ARM_IDS))}; got {servo_id!r}.")
        return self.servos[ARM_IDS.index(servo_id)]

    @property
    def q(self) -> tuple[float, float, float, float]:
        """The true joint angles (rad) now, play and all, which no encoder has rounded."""
        self.catch_up()
        return tuple(joint.link + joint.speed * (self.now - self.time) for joint in self.joints[:4])

    @property
    def opening(self) -> float:
        """Distance between the gripper's pads now, mm."""
        self.catch_up()
        return OPENING_AT_ZERO + 2 * FINGER_PER_RAD * self.joints[4].angle

    @property
    def grasped(self) -> Grasped | None:
        """What is between the fingers now."""
        self.catch_up()
        return self._between

    @property
    def busy(self) -> bool:
        """False while nothing moves and no counter runs: then only a packet, or a deadline, changes anything."""
        return any(servo.busy(self.time) for servo in self.servos)

    def place(self, q):
        """Move the joints (rad) by hand. Only what has no torque can be moved."""
        self.catch_up()
        for joint, servo, angle in zip(self.joints, self.servos, q, strict=False):
            if servo.torque_on:
                raise BadInput(f"Servo {servo.id} holds its joint: switch its torque off before you move it by hand.")
            joint.angle = min(max(float(angle), joint.low), joint.high)
        self.disturb()

    def push(self, *torques: float):
        """A hand pushes the joints with these torques (Nm), joint 1 first, until it is told otherwise."""
        self.catch_up()
        self._hand = (*map(float, torques), *(0.0,) * (5 - len(torques)))
        self.disturb()

    def grip(self, width: float | None, mass_g: float = 0.0, stiffness: float = 200.0):
        """Hold an object of `width` (mm) between the fingers, or take it away (None); see `Grasped`."""
        self.catch_up()
        self._between = None if width is None else Grasped(width, mass_g, stiffness)
        self.disturb()

    # ---- time ----

    def connect(self, now):
        """Someone has opened a line to the arm; `now()` is their time. False if someone else has."""
        if self._connected is not None:
            return False
        self._connected = now
        return True

    def disconnect(self):
        """The line is closed. Time stands still until the next one is opened."""
        self.catch_up()
        self._connected = None

    def catch_up(self):
        """Let the time pass that has passed for whoever is connected."""
        if self._connected:
            self.advance(self._connected())

    def disturb(self):
        """Something was changed from outside: every joint may move although it stood."""
        for servo in self.servos:
            servo.disturb()

    def at(self, time: float, action):
        """Call `action()` at the first step from `time` on."""
        self._events.append((time, action))
        self._events.sort(key=lambda event: event[0])

    def advance(self, now: float):
        """Let time pass until `now` (s). Times before the present are ignored."""
        with self.lock:
            if now > self.now:
                self.now = now
                self._run(int(now / STEP_S + 1e-9))

    def _run(self, last: int):
        while self._steps < last:
            while self._events and self._events[0][0] <= self.time:
                self._events.pop(0)[1]()
                self.disturb()
            if self.busy:
                self._step()
            else:
                self._look()
                self._pass(last)

    def _step(self):
        for joint in self.joints:
            joint.angle += joint.speed * STEP_S
        self._live(1)
        self._settle()
        if self._steps % EVERY == 0:
            self._look()

    def _look(self):
        """The world, if there is one, sees what the joints have done."""
        if self.world:
            before, self._between = self._between, self.world.look(self._between)
            if self._between is not before:
                self.disturb()

    def _pass(self, last: int):
        """Nothing moves until `last`: only temperatures and watchdogs notice that time passes."""
        alarms = [servo.deadline for servo in self.servos] + [event[0] for event in self._events[:1]]
        last = min(last, self._steps + THERMOMETER - self._steps % THERMOMETER)
        first = min(min(alarms) / STEP_S, last)
        self._live(max(ceil(first - 1e-9) - self._steps, 1))

    def _live(self, steps: int):
        self._steps += steps
        self.time, passed, look = self._steps * STEP_S, steps * STEP_S, self._steps % THERMOMETER == 0
        for servo in self.servos:
            servo.live(self.time, passed, look)

    def _settle(self):
        """Speeds and currents until the next step, from where everything is now."""
        time, joints = self.time, self.joints
        self._power()
        drives = [servo.drive(time, STEP_S) for servo in self.servos]
        held = not any(servo.been_on for servo in self.servos)
        on_grip, carried_g = self._grasp(drives[4].limit)
        _, *pitch, _ = [joint.angle for joint in joints]
        weight = (0.0, 0.0, 0.0) if held else gravity.torques(*pitch, (self.payload_g + carried_g) / 1000)
        limp = []
        for joint, drive, load, push in zip(joints, drives, (0.0, *weight, -on_grip), self._hand, strict=True):
            joint.settle(drive, load + push, STEP_S)
            if joint.speed and not drive.limit:
                limp.append(joint)
        if limp:
            self._rest_on_table(limp)

    def _grasp(self, limit: float) -> tuple[float, float]:
        """The torque (Nm) with which what is between the fingers keeps them open, and the mass that they carry (g)."""
        it, joint = self._between, self.joints[4]
        joint.contact = it.balance(limit - joint.friction) if it else inf
        if it is None:
            return 0.0, 0.0
        force = it.pressed(joint.angle)
        if it.carried and it.slips(force):
            self._between, joint.contact = None, inf
            self.disturb()
            return 0.0, 0.0
        it.carried = force > 0 and not it.slips(force)
        return force * GRIP_TORQUE_PER_N, it.mass_g if it.carried else 0.0

    def _rest_on_table(self, limp):
        """What is `limp` falls until the arm lies on the table."""
        pitch = self.joints[1:4]
        low = gravity.lowest(*(joint.angle + joint.speed * STEP_S for joint in pitch))
        if low < 0 and low < gravity.lowest(*(joint.angle for joint in pitch)):
            for joint in limp:
                joint.speed = 0.0

    def _power(self):
        amps = sum([STANDBY_MA + abs(joint.current) for joint in self.joints]) / 1000
        volts = self.supply - SUPPLY_OHMS * amps
        for servo in self.servos:
            servo.volts = volts


def _angles(q) -> list[float]:
    """Four joint angles (rad) that the frames of the arm allow."""
    angles = [float(a) for a in q]
    if len(angles) != 4:
        raise BadInput(f"`q` must be four joint angles in rad; got {len(angles)}.")
    for i, (angle, (low, high)) in enumerate(zip(angles, STOPS, strict=True), start=1):
        if not low - STOP_SLACK <= angle <= high + STOP_SLACK:
            span = f"{degrees(low):.1f} .. {degrees(high):.1f} deg"
            raise BadInput(
                f"q{i} = {degrees(angle):.1f} deg ({angle!r} rad) is beyond the stops of that joint: {span}."
            )
    return angles


def _few(value, name: str) -> float:
    """`value` degrees, at most 5, in rad."""
    return radians(as_number(value, name, "0 .. 5", 0, 5))
