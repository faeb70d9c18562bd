"""One XM430-W350: what its registers do to its motor, and what its motor does to its registers."""

from collections.abc import Callable
from functools import lru_cache
from math import degrees, expm1

from ...arm import MODEL, OVERLOAD_S, OVERLOAD_TORQUE, STALL_TORQUE, SUPPLY_VOLTS, TICKS_PER_TURN
from ..dynamixel import registers as reg
from ..dynamixel import units
from . import profile
from .control_table import FIRST_INDIRECT, GOALS, Table
from .controller import FULL_PWM, POSITION_MODES, Controller, Settings
from .joint import COAST, DAMPING, Drive, Encoder, Joint

REBOOT_S = 0.35
AMBIENT, HEATING, COOLING_S = 25.0, 35.0, 300.0  # degC, degC per A^2, s
_TICK = units.ANGLE.scale
_SPEED = units.VELOCITY.scale / _TICK  # ticks/s a unit of velocity
_ACCELERATION = units.ACCELERATION.scale / _TICK  # ticks/s^2 a unit of acceleration
_ARRIVED, _LOST = 20, 100  # ticks of error: "in position" below, "following error" above
_VOLT = units.VOLTAGE.scale
_MOMENT_S = 0.002  # the noise of the encoder changes this often


class Servo:
    """A servo on the bus, turning `joint`. Times are those of the arm's clock, in s."""

    def __init__(self, joint: Joint, servo_id: int):
        self.joint = joint
        self.encoder = Encoder()
        self.table = Table()
        self.table.put("id", servo_id)
        self.table.put("baud_rate", reg.BAUDS.index(1_000_000))
        self.table.put("model_number", MODEL)
        self.table.put("firmware_version", 45)
        self.registered: tuple[int, bytes] | None = None
        self.trajectory: profile.Trajectory | None = None
        self.temperature = AMBIENT
        self.volts = SUPPLY_VOLTS
        self.powered = True
        self.been_on = False  # whether its torque has ever been on
        self._controller = Controller()
        self._store: dict[str, int] = {}
        self._mount = self._stalled_s = 0.0
        self._turns = 0
        self._changed = True  # until the controller has seen it
        self._stepped = 0.0  # the time that the joint's angle belongs to
        self._asleep_until = self._booted = 0.0
        self.heard = 0.0  # when a packet for it came in last: the watchdog looks at it
        self._starting = False  # until it has done what it does at power-on
        self.table.put("goal_position", self.present())

    def __repr__(self) -> str:
        return f"Servo(id {self.id}, {degrees(self.joint.angle):.1f} deg)"

    @property
    def id(self) -> int:
        return self.table["id"]

    @property
    def settings(self) -> Settings:
        """What its registers come to."""
        if self.table.written:
            self.table.written = False  # first: what is written meanwhile counts the next time
            self._settings = Settings(self.table, self._mount, self._turns)
        return self._settings

    @property
    def mount(self) -> float:
        """By how much (rad) the horn was screwed on wrong."""
        return self._mount

    @mount.setter
    def mount(self, angle: float):
        self._mount, self.table.written = angle, True

    @property
    def torque_on(self) -> bool:
        return self.settings.torque_on

    @property
    def baud(self) -> int:
        return reg.BAUDS[self.table["baud_rate"]]

    def awake(self, now: float) -> bool:
        """False while it has no power or is rebooting: then it neither hears nor answers."""
        return self.powered and now >= self._asleep_until

    def hears(self, now: float, baud: int | None, protocol: int = 2) -> bool:
        """Whether it understands a packet at this rate, None being a line without one."""
        return self.table["protocol_type"] == protocol and self.awake(now) and baud in (None, self.baud)

    def listens_to(self, packet_id: int) -> bool:
        """Whether a packet with this id is for this servo: its id or its secondary id."""
        return packet_id == self.id or packet_id == self.table["secondary_id"] <= 252

    # ---- positions: rad at the joint, ticks in the registers ----

    def present(self) -> int:
        """The position (ticks) at the joint's last step, without noise."""
        return round(self._ticks(self.joint.angle))

    def _ticks(self, angle: float) -> float:
        settings = self.settings
        return settings.zero + settings.sign * self.encoder.reads(angle) / _TICK

    def wrap(self):
        """Forget whole turns, as at power-on and at torque-on in position mode."""
        turns = (self.present() - self.settings.offset) // TICKS_PER_TURN
        self._turns, self.table.written = self._turns - turns, True

    def angle_at(self, ticks: float) -> float:
        """The joint angle (rad) at which the position register reads `ticks`."""
        settings = self.settings
        return self.encoder.angle((ticks - settings.zero) * settings.sign * _TICK)

    # ---- what the motor is told ----

    def drive(self, now: float, dt: float) -> Drive:
        """What the motor is told for the next `dt` s."""
        self._changed, settings = False, self.settings
        if not (settings.torque_on and self.powered):
            return COAST
        position, speed = self._set_point(now)
        full = STALL_TORQUE * self.volts / SUPPLY_VOLTS
        goal = self.angle_at(position), settings.sign * speed * _TICK
        return self._controller.drive(settings, full, self.joint.angle, *goal, dt)

    def _set_point(self, now: float) -> tuple[float, float]:
        """Where the set-point is and how fast it moves (ticks, ticks/s): where the joint is, if there is none."""
        return self.trajectory.at(now) if self.trajectory else (self._ticks(self.joint.angle), 0.0)

    def running(self, now: float) -> bool:
        """True while the set-point still moves, or speeds up or slows down."""
        return self.trajectory is not None and now < self.trajectory.steady_from

    @property
    def velocity(self) -> int:
        """Present velocity, in the register's units."""
        return units.VELOCITY.raw(self.settings.sign * self.joint.speed)

    def moving(self, now: float) -> bool:
        """What the register `moving` says: the set-point runs, or the joint is faster than the threshold."""
        return self.running(now) or abs(self.velocity) > self.table["moving_threshold"]

    def busy(self, now: float) -> bool:
        """False if nothing changes until the next command: the motor stands and no counter runs."""
        moves = self._changed or self.joint.speed or self._controller.gathering or self._stalled_s
        return bool(moves or self.running(now))

    def disturb(self):
        """Something has changed from outside: the joint may move although it stood."""
        self._changed = True

    # ---- what time does to it ----

    def live(self, now: float, dt: float, look: bool):
        """`dt` seconds have passed, it is `now`; `look` says that it is time to look at the thermometer."""
        self._stepped, joint = now, self.joint
        amps = joint.current / 1000
        warmth = AMBIENT + HEATING * amps * amps
        self.temperature += (warmth - self.temperature) * -expm1(-dt / COOLING_S)
        self._stalled_s = self._stalled_s + dt if abs(joint.effort) > OVERLOAD_TORQUE else 0
        if self.awake(now):
            self._inspect(now, look)

    def _inspect(self, now: float, look: bool):
        """Start, if that is due, and notice what is wrong: a long stall, heat, a wrong voltage, silence on the bus."""
        if self._starting:
            self.start(now)
        if self._stalled_s > OVERLOAD_S:
            self.fail(reg.OVERLOAD)
        if look and self.temperature > self.table["temperature_limit"]:
            self.fail(reg.OVERHEATED)
        fewest, most = self.settings.voltages
        if not fewest <= round(self.volts / _VOLT) <= most:
            self.fail(reg.VOLTAGE)
        if now >= self._watchdog_at:
            self._trip(now)

    @property
    def _watchdog_at(self) -> float:
        """When the watchdog trips if nothing is heard until then; never if it is not armed."""
        return self.heard + self.settings.patience

    @property
    def deadline(self) -> float:
        """When it next does something by itself, if nothing is heard until then."""
        return self._asleep_until if self._starting else self._watchdog_at

    def fail(self, bits: int):
        """Set hardware error bits; those in the shutdown mask switch the torque off."""
        self.table.put("hardware_error", self.table["hardware_error"] | bits)
        if bits & self.table["shutdown"]:
            self.table.put("torque_enable", 0)
            self.release()

    def release(self):
        """The torque is off: forget where the set-point was going."""
        self.trajectory = None
        self._controller.reset()
        self._stalled_s = 0
        self.disturb()

    def _trip(self, now: float):
        self.table.put("bus_watchdog", reg.WATCHDOG_TRIPPED)
        for name in ("profile_velocity", "profile_acceleration", "goal_velocity"):
            self.table.put(name, 0)
        mode = self.table["operating_mode"]
        for name in ("pwm", "current"):
            if mode == reg.MODES[name]:
                self.table.put(f"goal_{name}", 0)
        self.hold(now)

    def hold(self, now: float):
        """Stop where the joint is, set-point and all."""
        self.trajectory = profile.step(now, self.present())
        self.disturb()

    def clear_turns(self, now: float):
        """Forget whole turns and stay where the joint is."""
        self.wrap()
        self.table.put("goal_position", self.present())
        if self.torque_on:
            self.hold(now)

    # ---- starting, and the servo's store ----

    def reboot(self, now: float):
        """Start again: RAM to its defaults, silent for a while."""
        self.table.restore(keep=lambda row: row.eeprom)
        self.table.put("hardware_error", 0)
        self.table.put("registered_instruction", 0)
        self.table.put("goal_pwm", self.table["pwm_limit"])
        self.table.put("goal_current", self.table["current_limit"])
        self.registered = None
        self.release()
        self._asleep_until = self._booted = now + REBOOT_S
        self._starting = True
        self.wrap()
        self.table.put("goal_position", self.present())

    def start(self, now: float):
        """It is awake: do what startup_configuration asks for."""
        self._starting = False
        wanted = self.table["startup_configuration"]
        if wanted & reg.STARTUP_RESTORE_RAM:
            self._take(reg.GAINS)
        if wanted & reg.STARTUP_TORQUE_ON:
            self.table.put("goal_position", self.present())
            self.set("torque_enable", 1, now)

    def store(self):
        """Keep EEPROM and gains, as the instruction BACKUP does."""
        kept = [row.name for row in reg.REGISTERS.values() if row.writable and (row.eeprom or row.name in reg.GAINS)]
        self._store = {name: self.table[name] for name in kept}
        self.table.put("backup_ready", 1)

    def restore(self, now: float):
        """EEPROM as it was kept, and a reboot."""
        self._take(row.name for row in reg.REGISTERS.values() if row.eeprom)
        self.reboot(now)

    def _take(self, names):
        for name in names:
            if name in self._store:
                self.table.put(name, self._store[name])

    def power_up(self, now: float):
        """The supply is back."""
        self.powered = True
        self.reboot(now)

    def factory_reset(self, now: float, keep: tuple[str, ...]):
        """EEPROM to the factory's values, but for the registers named in `keep`, and a reboot."""
        self.table.restore(keep=lambda row: row.name in keep)
        self.reboot(now)

    # ---- registers ----

    def read(self, address: int, length: int, now: float) -> bytes:
        """Bytes of the control table as they are now."""
        for row, reads in _live(address, length):
            self.table.show(row, reads(self, now))
        return self.table.read(address, length)

    def check(self, address: int, data: bytes) -> list[tuple[reg.Register, int]]:
        """The registers that `data` at `address` would set; `Refusal` if one of them must not be."""
        changes = self.table.changes(address, data)
        for row, value in changes:
            self.table.check(row, value)
        return changes

    def write(self, address: int, data: bytes, now: float):
        """Set registers, all or none; `Refusal` with the error code of the status packet."""
        for row, value in self.check(address, data):
            self.set(row.name, value, now)

    def set(self, name: str, value: int, now: float = 0.0):
        """Set a register, permitted or not, with all that this sets off."""
        before = self.table[name]
        self.table.put(name, value)
        if name == "torque_enable":
            self._switched(now)
        elif name == "operating_mode" and value != before:
            self.table.new_mode()
            self._wrap_in_position_mode()
        elif name in GOALS:
            self._new_goal(name, now)
        self.been_on = self.been_on or self.torque_on
        self.disturb()

    def _switched(self, now: float):
        """The torque has been switched on, or off."""
        if not self.torque_on:
            self.release()
        elif self.trajectory is None:
            # Whether real firmware sets the goal to the present position here is not known. This one does not.
            self._wrap_in_position_mode()
            self.plan(now)

    def _new_goal(self, name: str, now: float):
        table = self.table
        if self.torque_on:  # the goals of other modes lay nothing anew
            if name == ("goal_velocity" if table["operating_mode"] == reg.MODES["velocity"] else "goal_position"):
                self.plan(now)
        elif table["drive_mode"] & reg.DRIVE_TORQUE_BY_GOAL and not table["hardware_error"] & table["shutdown"]:
            table.put("torque_enable", 1)
            self._switched(now)

    def _wrap_in_position_mode(self):
        if self.table["operating_mode"] == reg.MODES["position"]:
            self.wrap()

    def plan(self, now: float):
        """Lay the trajectory to the goal that the registers hold now."""
        table = self.table
        position, speed = self.trajectory.at(now) if self.trajectory else (self.present(), 0.0)
        timed = table["drive_mode"] & reg.DRIVE_TIME_BASED and table["firmware_version"] >= 42
        ramp, span, goal = table["profile_acceleration"], table["profile_velocity"], table["goal_position"]
        if table["operating_mode"] == reg.MODES["velocity"]:
            wanted = table["goal_velocity"] * _SPEED
            rate = ramp * _ACCELERATION
            if timed:
                rate = abs(wanted - speed) / (ramp / 1000) if ramp else 0.0
            self.trajectory = profile.to_speed(now, speed, wanted, rate)
        elif not span:
            self.trajectory = profile.step(now, goal)
        elif timed:
            self.trajectory = profile.by_time(now, position, speed, goal, span / 1000, ramp / 1000)
        else:
            cruise = min(span, table["velocity_limit"] or span) * _SPEED
            self.trajectory = profile.by_speed(now, position, speed, goal, cruise, ramp * _ACCELERATION)

    # ---- what the registers say that report the present ----

    def _position(self, now: float) -> int:
        angle = self.joint.angle + self.joint.speed * (now - self._stepped)
        noise = self.settings.sign * self.encoder.jitter(self.id, round(now / _MOMENT_S)) / _TICK
        return round(self._ticks(angle) + noise)

    def _aim(self, now: float) -> int:
        """Where the set-point is; in modes without one, where the joint is."""
        in_position = self.trajectory and self.table["operating_mode"] in POSITION_MODES
        return round(self.trajectory.at(now)[0]) if in_position else self._position(now)

    def _duty(self, now: float) -> int:
        if not self.torque_on:
            return 0
        duty = (self.joint.effort + DAMPING * self.joint.speed) / (STALL_TORQUE * self.volts / SUPPLY_VOLTS)
        return round(self.settings.sign * min(max(duty, -1), 1) * FULL_PWM)

    def _status(self, now: float) -> int:
        running, error = self.running(now), abs(self._aim(now) - self._position(now))
        shape = self.trajectory.shape << 4 if running else 0
        return running << 1 | shape | (not running and error <= _ARRIVED) | (error > _LOST) << 3


#: The registers that report the present: what each one reads at a time.
_LIVE = {
    "realtime_tick": lambda servo, now: int((now - servo._booted) * 1000) % 32768,
    "moving": Servo.moving,
    "moving_status": Servo._status,
    "present_pwm": Servo._duty,
    "present_current": lambda servo, now: units.CURRENT.raw(servo.settings.sign * servo.joint.current),
    "present_velocity": lambda servo, now: servo.velocity,
    "present_position": Servo._position,
    "velocity_trajectory": lambda servo, now: round(servo._set_point(now)[1] / _SPEED),
    "position_trajectory": Servo._aim,
    "present_voltage": lambda servo, now: units.VOLTAGE.raw(servo.volts),
    "present_temperature": lambda servo, now: round(servo.temperature),
}


@lru_cache
def _live(address: int, length: int) -> list[tuple[reg.Register, Callable[[Servo, float], int]]]:
    """Those of them that show in `length` bytes from `address`: all, if those stand for others."""
    end = address + length
    rows = [(reg.REGISTERS[name], reads) for name, reads in _LIVE.items()]
    return [(row, reads) for row, reads in rows if end > FIRST_INDIRECT or (row.address < end and row.end > address)]
