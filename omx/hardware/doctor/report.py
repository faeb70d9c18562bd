"""What the doctor says: findings as data, and a report that reads well."""

import sys
from dataclasses import dataclass, field, replace

from .diagnoses import ILLNESSES

#: What the levels mean: a fault stops the arm, a warning will, a note is worth knowing.
LEVELS = ("fault", "warning", "note")
_SIGNS = {"fault": "[x]", "warning": "[!]", "note": "[i]"}


@dataclass(frozen=True)
class Finding:
    """One thing found: `key` names the illness, `level` is one of LEVELS, and `servo` the id if it is one servo's."""

    key: str
    symptom: str
    cause: str
    remedy: str
    level: str = "fault"
    servo: int | None = None

    def __str__(self) -> str:
        return f"{_SIGNS[self.level]} {self.symptom}\n      why: {self.cause}\n      do:  {self.remedy}"


def find(key: str, servo: int | None = None, system: str = sys.platform, **facts) -> Finding:
    """The illness `key` with its blanks filled in: on `system` ("linux", "darwin", "win32") if remedies differ."""
    level, symptom, cause, remedy = ILLNESSES[key]
    if isinstance(remedy, dict):
        remedy = remedy.get(system, remedy["linux"])
    facts["servo"] = servo
    return Finding(key, symptom.format(**facts), cause.format(**facts), remedy.format(**facts), level, servo)


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
    *others, last = findings
    if len({finding.symptom.replace(f"servo {finding.servo}", "") for finding in findings}) == 1 and others:
        all_of_them = f"each of the servos {', '.join(str(finding.servo) for finding in findings)}"
        others, last = [], replace(last, symptom=last.symptom.replace(f"servo {last.servo}", all_of_them))
    return "\n".join([*(f"{_SIGNS[other.level]} {other.symptom}" for other in others), str(last)])
