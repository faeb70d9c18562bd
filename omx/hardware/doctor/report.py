"""What the doctor says: findings as data, what an exception means, and a report that reads well."""

import errno
import sys
from dataclasses import dataclass, field

from ...errors import BusCorrupt, BusTimeout, OmxError, PortBusy, PortError, PortLost, ServoFault
from ..fault_table import Finding, hardware_words
from .diagnoses import ILLNESSES

#: What the levels mean: a fault stops the arm, a warning will, a note is worth knowing.
LEVELS = ("fault", "warning", "note")
_SIGNS = {"fault": "[x]", "warning": "[!]", "note": "[i]"}
_PORT = {errno.EACCES: "no_permission", errno.ENOENT: "port_absent", errno.EBUSY: "port_busy"}


def find(key: str, servo: int | None = None, system: str = sys.platform, **facts) -> Finding:
    """The illness `key` with its blanks filled in: on `system` ("linux", "darwin", "win32") if remedies differ."""
    return ILLNESSES[key].finding(servo, facts, system)


def explain(error: OmxError) -> list[Finding]:
    """What an exception of the bus means and what to do about it; empty if it is no matter of the bus."""
    if isinstance(error, PortLost):
        return [find("port_lost", port=error.port)]
    if isinstance(error, PortError):
        key = "port_busy" if isinstance(error, PortBusy) else _PORT.get(error.errno, "port_error")
        return [find(key, port=error.port, text=str(error), who="")]
    if isinstance(error, ServoFault):
        return [find("hardware_error", servo, **hardware_words(bits)) for servo, bits in error.faults.items()]
    if isinstance(error, BusTimeout):
        return [find("lost", error.missing[0], count=1, asked=1, ids=f"servo {error.missing[0]}")]
    if isinstance(error, BusCorrupt):
        return [find("corrupt", error.servo, count=1, asked=1, ids=f"servo {error.servo}")]
    return []


@dataclass
class Report:
    """All that was found, and the `facts` that are as they should be."""

    findings: list[Finding] = field(default_factory=list)
    facts: list[str] = field(default_factory=list)

    def add(self, key: str, servo: int | None = None, **facts) -> None:
        """Add the illness `key`."""
        self.findings.append(find(key, servo, **facts))

    @property
    def healthy(self) -> bool:
        """True if there is nothing to mend; notes do not count."""
        return all(finding.level == "note" for finding in self.findings)

    @property
    def keys(self) -> set[str]:
        """The names of all illnesses found."""
        return {finding.key for finding in self.findings}

    def __str__(self) -> str:
        lines = [f"[ok] {fact}" for fact in self.facts]
        lines += [_told(group) for group in self._groups()]
        wrong = sum(finding.level != "note" for finding in self.findings)
        lines.append(f"{wrong} thing{'s' * (wrong != 1)} to mend." if wrong else "Nothing to mend.")
        if wrong == 1 and "no_ports" in self.keys:
            lines[-1] = "1 thing to mend if an arm is plugged in, nothing if you have none."
        return "\n".join(lines)

    __repr__ = __str__

    def _groups(self) -> list[list[Finding]]:
        """Findings with the same cause and remedy together, by the ids of their servos; faults first."""
        groups: dict[tuple, list[Finding]] = {}
        for finding in sorted(self.findings, key=lambda f: (LEVELS.index(f.level), f.servo or 0)):
            groups.setdefault((finding.key, finding.cause, finding.remedy), []).append(finding)
        return list(groups.values())


def _told(findings: list[Finding]) -> str:
    """Findings of one cause, each in its line; those that differ in nothing but the servo in one."""
    first, symptoms = findings[0], [finding.symptom for finding in findings]
    if len({finding.symptom.replace(f"servo {finding.servo}", "") for finding in findings}) == 1 < len(findings):
        all_of_them = f"each of the servos {', '.join(str(finding.servo) for finding in findings)}"
        symptoms = [first.symptom.replace(f"servo {first.servo}", all_of_them)]
    lines = [f"{_SIGNS[first.level]} {symptom}" for symptom in symptoms]
    return "\n".join([*lines, f"      why: {first.cause}", f"      do:  {first.remedy}"])
