"""The bus: registers of servos by name, over one port. Values are raw integers.

Whatever goes wrong is an exception; each transaction holds a lock; an interrupted one leaves nothing behind; and
what went over the wire is kept.
"""

import contextlib
import threading
from collections import deque
from operator import index
from typing import NamedTuple

from ...arrays import shown
from ...errors import BadInput, BusCorrupt, BusError, BusTimeout, PortBusy, PortLost, ReadOnly, ServoFault, ServoRefused
from . import packet as pk
from .packet import Instruction as Do
from .registers import PRESENT, Block, Register, block, hardware_errors, register
from .sdk import Damage, Port, Protocol, Silence
from .trace import Transaction


class Ping(NamedTuple):
    """Who answered a ping."""

    model: int
    firmware: int


class Answer(NamedTuple):
    """What one servo said: its id, its error number (alert bit removed) and its data."""

    servo: int
    error: int
    data: bytes


class Bus:
    """Servos on one port.

    `port` is a name ("/dev/ttyUSB0", "COM5", "socket://127.0.0.1:PORT") or a `Port`, such as a `VirtualPort`.
    Raises PortError if it cannot be opened. Every method raises a BusError when the wire fails and BadInput,
    before anything is sent, when its arguments are wrong.
    """

    def __init__(self, port, baud: int = 1_000_000, history: int = 1000):
        self._port = Port(port) if isinstance(port, str) else port
        if not isinstance(self._port, Port):
            raise BadInput(f"`port` is a name, such as '/dev/ttyUSB0' or 'COM5', or a Port; got {shown(port)}.")
        self._line = None  # ours, while it is the port's: a port outlives its buses
        self._protocol = Protocol()
        self._lock = threading.RLock()
        self._stale, self._asking = False, 0
        self.history: deque[Transaction] = deque(maxlen=history)
        self.alerts: set[int] = set()
        self.strays = 0
        self.tune(baud)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def __repr__(self) -> str:
        return f"Bus({self.name!r}, {'open' if self.is_open else 'closed'})"

    @property
    def name(self) -> str:
        """The port's name."""
        return self._port.port_name

    @property
    def clock(self):
        """The clock this port lives by: `now()` and `sleep(seconds)`. The virtual arm's may run faster."""
        return self._port.clock

    @property
    def is_open(self) -> bool:
        """False after `close`, and after the port has gone; another bus may have it then."""
        return self._port.is_open and self._port.ser is self._line

    @property
    def asking(self) -> bool:
        """True in the middle of a transaction of this very thread; those of other threads are waited for."""
        return self._asking == threading.get_ident()

    def refuse_if_read_only(self, doing: str):
        """Raise ReadOnly if nothing but questions may go over this port."""
        if self._port.read_only:
            raise ReadOnly(self.name, doing)

    def tune(self, baud: int):
        """Open the port at another baud rate, one that the servos know."""
        if self._port.getCFlagBaud(baud) <= 0:
            raise BadInput(f"baud {baud!r} is not one that the adapter knows; the arm's is 1000000.")
        with self._lock:
            self._open(baud)

    def close(self):
        """Let the port go. The servos keep doing what they were told last."""
        with self._lock:
            if self.is_open:
                self._port.closePort()

    def reopen(self):
        """Open the port again, after it was closed or lost."""
        with self._lock:
            self._open(self._port.baudrate)
            self._stale = True

    def _open(self, baud: int):
        if self._port.is_open and not self.is_open:
            raise PortBusy(self.name, "another bus of this program has this very port. Close that one first")
        self._port.baudrate = baud
        self._port.openPort()
        self._line = self._port.ser

    # ---- one servo ----

    def ping(self, servo: int) -> Ping:
        """Model number and firmware version of one servo."""
        (answer,) = self._ask(_id(servo), Do.PING, b"", [(servo, 3)], "answer a ping")
        return Ping(pk.word(answer.data), answer.data[2])

    def scan(self, servos) -> dict[int, Ping]:
        """Whoever answers a ping, one after the other: 0.3 ms for each that is there, 34 ms for each that is not."""
        found = {}
        for servo in _ids(servos):
            with contextlib.suppress(BusTimeout, BusCorrupt):
                found[servo] = self.ping(servo)
        return found

    def read(self, servo: int, name: str) -> int:
        """The register `name` of one servo."""
        row = register(name)
        params = pk.words(row.address, row.size)
        (answer,) = self._ask(_id(servo), Do.READ, params, [(servo, row.size)], f"read {row.name}")
        return row.decode(answer.data)

    def write(self, servo: int, name: str, value: int):
        """Set the register `name` of one servo, and see that it confirms."""
        row, data = _encoded(name, value)
        params = pk.words(row.address) + data
        self._ask(_id(servo), Do.WRITE, params, [(servo, 0)], f"set {row.name} to {value}", row)

    def reboot(self, servo: int):
        """Restart one servo: it goes limp, clears its hardware error and is silent for about 0.4 s."""
        self._ask(_id(servo), Do.REBOOT, b"", [(servo, 0)], "reboot")
        self.alerts.discard(servo)

    # ---- several servos in one transaction ----

    def read_all(self, servos, name: str) -> dict[int, int]:
        """The register `name` of several servos, in one transaction."""
        return {servo: values[0] for servo, values in self.read_block(servos, block(name)).items()}

    def read_block(self, servos, what: Block = PRESENT) -> dict[int, tuple[int, ...]]:
        """Neighbouring registers of several servos in one transaction: id -> one integer a register.

        The default is what one look at a servo is: present current, velocity, position.
        """
        ids = _ids(servos)
        params = pk.words(what.address, what.size) + bytes(ids)
        wanted = [(servo, what.size) for servo in ids]
        answers = self._ask(pk.BROADCAST, Do.SYNC_READ, params, wanted, f"read {what.names}")
        return {answer.servo: what.decode(answer.data) for answer in answers}

    def write_block(self, what: Block, values: dict[int, tuple[int, ...]]):
        """Set neighbouring registers of several servos, id -> one value a register, in one packet.

        Each servo sets all of them or, if one is refused, none. Servos do not confirm this.
        """
        ids = _ids(values)
        data = [bytes((servo,)) + _block_encoded(what, values[servo]) for servo in ids]
        params = pk.words(what.address, what.size) + b"".join(data)
        self._ask(pk.BROADCAST, Do.SYNC_WRITE, params, [], f"set {what.names}")

    def write_all(self, name: str, values: dict[int, int]):
        """Set the register `name` of several servos, id -> value, in one packet. Servos do not confirm this."""
        self.write_block(block(name), {servo: (value,) for servo, value in values.items()})

    # ---- what is wrong with them ----

    def check_hardware(self, servos):
        """Raise ServoFault if any of these servos reports a hardware error."""
        self._raise_faults(self.read_all(servos, "hardware_error"))

    def _raise_faults(self, bits: dict[int, int]):
        faults = {servo: b for servo, b in bits.items() if b}
        if faults:
            raise ServoFault(self.name, faults, {servo: hardware_errors(b) for servo, b in faults.items()})

    # ---- one transaction ----

    def _ask(self, to, instruction, params, wanted, doing, row: Register | None = None) -> list[Answer]:
        """Send one packet and collect the answers of `wanted`, pairs of id and number of data bytes."""
        if instruction not in pk.QUESTIONS:
            self.refuse_if_read_only(doing)
        with self._lock:
            if not self.is_open:
                raise PortLost(self.name, "the port is closed. Call reopen(), or make a new connection.")
            if (self._stale or self._asking) and wanted and instruction != Do.PING:
                self._catch_up(wanted[0][0])
            answers = self._exchange(to, instruction, params, wanted, doing)
        for answer in answers:
            if answer.error:
                self._refused(answer, doing, row)
        return answers

    def _catch_up(self, servo: int):
        """After a failure, or in the middle of another transaction, as in a signal's handler, an answer may still be
        under way, and would be taken for the next one.

        Answers come in order, and the answer to a ping cannot be mistaken: once it is here, the late ones have passed.
        """
        self._exchange(servo, Do.PING, b"", [(servo, 3)], "answer a ping")

    def _exchange(self, to, instruction, params, wanted, doing) -> list[Answer]:
        port, began, fault, before = self._port, self.clock.now(), None, self._asking
        port.is_using, self._asking = False, threading.get_ident()
        try:
            self.strays += bool(port.getBytesAvailable()) if wanted else 0
            self._protocol.send(port, to, instruction, params, sum(size + 11 for _, size in wanted))
            answers = self._receive(wanted, doing)
            self._stale = self._stale and instruction != Do.PING
            return answers
        except BaseException as error:  # a KeyboardInterrupt too must not leave the port marked as in use
            fault = error
            raise
        finally:
            port.is_using, self._asking = False, before
            self._stale = self._stale or fault is not None
            spent = self.clock.now() - began
            trouble = f"{type(fault).__name__}: {fault}" if fault else ""
            self.history.append(Transaction(began, spent, port.sent, bytes(port.received), trouble))

    def _receive(self, wanted, doing) -> list[Answer]:
        answers = []
        try:
            for servo, size in wanted:
                answers.append(self._receive_one(servo, size))
        except Silence:
            missing = [servo for servo, _ in wanted[len(answers) :]]
            raise BusTimeout(self.name, doing, missing, [answer.servo for answer in answers]) from None
        except Damage:
            raise BusCorrupt(self.name, doing, wanted[len(answers)][0], bytes(self._port.received)) from None
        return answers

    def _receive_one(self, servo, size) -> Answer:
        while True:
            frame = self._protocol.receive(self._port)
            sender, error, data = frame[4], frame[8], bytes(frame[9:-2])
            if sender == servo and (len(data) == size or error & ~pk.ALERT):
                (self.alerts.add if error & pk.ALERT else self.alerts.discard)(servo)
                return Answer(servo, error & ~pk.ALERT, data)
            self.strays += 1  # a late answer to an earlier question: the right one comes after it

    def _refused(self, answer: Answer, doing: str, row: Register | None):
        if answer.servo in self.alerts and answer.error == pk.RESULT_FAIL:
            self._raise_faults({answer.servo: self.read(answer.servo, "hardware_error")})
        raise ServoRefused(self.name, doing, answer.servo, answer.error, _reason(answer.error, row))


def again(call, *args, times: int = 2):
    """`call(*args)`, up to `times` times while it, or its answer, is lost or damaged. For what does no harm twice."""
    for left in reversed(range(times)):
        try:
            return call(*args)
        except (BusTimeout, BusCorrupt, ServoRefused) as error:
            if not left or (isinstance(error, ServoRefused) and error.code != pk.CRC_ERROR):
                raise


def for_each(servos, do) -> None:
    """`do(servo)` for each, whatever fails on the way; then what failed first is raised."""
    failed = []
    for servo in servos:
        try:
            do(servo)
        except BusError as error:
            failed.append(error)
    if failed:
        raise failed[0]


def _reason(code: int, row: Register | None) -> str:
    said = pk.STATUS_ERRORS.get(code, f"error {code}")
    if code == pk.ACCESS and row and row.eeprom:
        return f"{said}: {row.name} is in the EEPROM, which is locked while torque is on. Switch the torque off first"
    if code == pk.DATA_LIMIT:
        return f"{said}: the value is outside a limit that the servo holds in another register"
    if code == pk.DATA_RANGE and row and row.name.startswith("goal"):
        return f"{said}: out of range, or the bus watchdog has tripped (write 0 to bus_watchdog to go on)"
    return said


def _encoded(name: str, value: int) -> tuple[Register, bytes]:
    row = register(name)
    if not row.writable:
        raise BadInput(f"{row.name} is read-only.")
    return row, row.encode(value)


def _block_encoded(what: Block, values) -> bytes:
    pairs = zip(what.registers, values, strict=True)
    return b"".join(_encoded(row.name, value)[1] for row, value in pairs)


def _id(servo) -> int:
    try:
        number = index(servo)
    except TypeError:
        number = -1
    if not 0 <= number <= pk.MAX_ID:
        raise BadInput(f"A servo's id is a whole number 0 .. {pk.MAX_ID}; got {servo!r}. The arm's are 11 .. 15.")
    return number


def _ids(servos) -> list[int]:
    ids = [_id(servo) for servo in servos]
    if not ids or len(set(ids)) != len(ids):
        raise BadInput(f"Give one or more servo ids, each once; got {ids}.")
    return ids
