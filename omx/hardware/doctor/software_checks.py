"""The software side: is the SDK the right one, and who may use, and who uses, the ports? Needs no arm."""

import base64
import contextlib
import hashlib
import os
import sys
from importlib import metadata
from pathlib import Path

from .report import Report

OLDEST_SDK = (4, 0, 5)
#: The package that is imported -> the distribution that it should come from.
PACKAGES = {"dynamixel_sdk": "dynamixel-sdk", "serial": "pyserial"}


def examine_software(report: Report, path: list[str] | None = None) -> None:
    """The SDK's version, and whether another package has written over it; `path` is where to look (sys.path)."""
    found = list(metadata.distributions(path=sys.path if path is None else path))
    sdk = next((d for d in found if _name(d) == "dynamixel-sdk"), None)
    if sdk is None:
        report.add("sdk_missing")
    elif _version(sdk.version) < OLDEST_SDK:
        report.add("sdk_old", version=sdk.version)
    else:
        report.facts.append(f"dynamixel-sdk {sdk.version}")
    for package, wanted in PACKAGES.items():
        _shadowed(report, found, package, wanted)


def _shadowed(report: Report, found, package: str, wanted: str) -> None:
    mine = next((d for d in found if _name(d) == wanted), None)
    rivals = sorted({_name(d) for d in found if _name(d) != wanted and _brings(d, package)})
    changed = _changed(mine, package) if mine else []
    if rivals or changed:
        who = f"{', '.join(rivals)} brings it too" if rivals else f"{changed[0]} has been written over"
        rival = " ".join(rivals) or "dynamixel-controller"
        report.add("sdk_shadowed", package=package, wanted=wanted, who=who, rival=rival)


def _brings(distribution, package: str) -> bool:
    record = distribution.read_text("RECORD") or distribution.read_text("installed-files.txt") or ""
    return f"\n{package}/" in f"\n{record}"


def _changed(distribution, package: str) -> list[str]:
    """Files of `package` whose contents are not those that were installed."""
    ours = [file for file in distribution.files or () if str(file).startswith(f"{package}/") and file.hash]
    return [str(file) for file in ours if _digest(Path(file.locate())) not in (file.hash.value, None)]


def _digest(file: Path) -> str | None:
    try:
        return base64.urlsafe_b64encode(hashlib.sha256(file.read_bytes()).digest()).rstrip(b"=").decode()
    except OSError:
        return None


def _name(distribution) -> str:
    return (distribution.metadata["Name"] or "").lower().replace("_", "-")


def _version(text: str) -> tuple[int, ...]:
    return tuple(int("".join(filter(str.isdigit, part)) or 0) for part in text.split(".")[:3])


def holder(port: str) -> str:
    """Who has `port` open, as far as Linux lets us see: `, by python (process 4711)`; empty if unknown."""
    target = os.path.realpath(port)
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has ended, or is someone else's
            if int(process.name) != os.getpid() and any(os.path.realpath(fd) == target for fd in process.glob("fd/*")):
                return f", by {(process / 'comm').read_text().strip()} (process {process.name})"
    return ""


def examine_port_name(report: Report, port: str) -> None:
    """What can be told from the name of a port alone: does a modem program play with it?"""
    if os.path.basename(port).startswith("ttyACM") and _runs("ModemManager"):
        report.add("modem_manager", port=port)


def _runs(program: str) -> bool:
    for comm in Path("/proc").glob("[0-9]*/comm"):
        with contextlib.suppress(OSError):
            if comm.read_text().strip() == program[:15]:
                return True
    return False
