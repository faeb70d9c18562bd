"""From an exception of the bus to a finding: what the servo, or the port, meant by it."""

import errno

from ...errors import (
    BusCorrupt,
    BusTimeout,
    OmxError,
    PortBusy,
    PortError,
    PortLost,
    ServoFault,
)
from ..fault_table import hardware_words
from .report import Finding, find

_PORT = {errno.EACCES: "no_permission", errno.ENOENT: "port_absent", errno.EBUSY: "port_busy"}


def explain(error: OmxError) -> list[Finding]:
    """What an exception of the bus means and what to do about it; empty if it is no matter of the bus."""
    if isinstance(error, PortError):
        return [_port(error)]
    if isinstance(error, ServoFault):
        return [hardware(servo, bits) for servo, bits in error.faults.items()]
    if isinstance(error, BusTimeout):
        return [find("lost", error.missing[0], count=1, asked=1, ids=f"servo {error.missing[0]}")]
    if isinstance(error, BusCorrupt):
        return [find("corrupt", error.servo, count=1, asked=1, ids=f"servo {error.servo}")]
    return []


def _port(error: PortError) -> Finding:
    if isinstance(error, PortLost):
        return find("port_lost", port=error.port)
    key = "port_busy" if isinstance(error, PortBusy) else _PORT.get(error.errno, "port_error")
    return find(key, port=error.port, text=str(error), who="")


def hardware(servo: int, bits: int) -> Finding:
    """The bits of register 70 in words, with what brings them about."""
    return find("hardware_error", servo, **hardware_words(bits))
