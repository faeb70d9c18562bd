"""What the measurements were taken on."""

import os
import platform
import sys
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import psutil

#: Whose versions matter, where they are installed.
PACKAGES = ("numpy", "pin")


def describe(packages=PACKAGES) -> str:
    """Processor, cores, load, and the versions that matter."""
    parts = [f"{processor()}, {os.cpu_count()} cores{_load()}; Python {platform.python_version()}"]
    return ", ".join([*parts, *versions(packages)])


def processor() -> str:
    """The processor's name, as the system tells it."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    model = next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), "")
    return model or platform.processor() or platform.machine()


def allowed() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def memory() -> str:
    """The main memory, where the system tells it."""
    try:
        return f"{os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 2**30:.0f} GB"
    except (AttributeError, ValueError, OSError):
        return "unknown"


def system() -> str:
    """The operating system and the interpreter."""
    return f"{platform.system()} {platform.machine()}, {platform.python_implementation()} {sys.version.split()[0]}"


def versions(packages) -> list[str]:
    """`name version` of each package, or `no name`."""
    return [_version(package) for package in packages]


class Watch:
    """Watches, from its making on, how much of the processors' time others take."""

    def __init__(self):
        self._start = _busy()

    def others(self) -> float | None:
        """The share (0 to 1) of all processors' time that went to processes other than this one and its children.

        None on Windows, which does not tell what children have used.
        """
        if os.name == "nt":
            return None
        (wall, busy, own), (wall_0, busy_0, own_0) = _busy(), self._start
        theirs = (busy - busy_0) - (own - own_0)
        return min(1.0, max(0.0, theirs / ((wall - wall_0) * os.cpu_count())))


def _busy() -> tuple[float, float, float]:
    """Seconds: of the clock, of work by all processors, of work by this process and the children that have ended."""
    all_of_it = psutil.cpu_times()
    idle = all_of_it.idle + getattr(all_of_it, "iowait", 0.0)
    counted = sum(value for name, value in all_of_it._asdict().items() if name not in ("guest", "guest_nice"))
    return time.perf_counter(), counted - idle, sum(os.times()[:4])


def load() -> float | None:
    """How many processes wanted a processor over the last minute; None where the system does not tell."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def _load() -> str:
    return "" if load() is None else f", load {load():.1f}"


def _version(package: str) -> str:
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        return f"no {package}"
