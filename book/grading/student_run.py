"""Runs one student's notebook: `sandbox` in a process of its own, as often as it takes, and what that said."""

import contextlib
import json
import os
import secrets
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
from pathlib import Path

from book.setup.paths import ROOT, VENV

CELL_TIMEOUT_S, STUDENT_TIMEOUT_S = 30, 600
POLL_S = 0.02
SANDBOX = Path(__file__).with_name("sandbox.py")


class Report:
    """What the grader's process said: criteria, cells that stopped, tampering."""

    def __init__(self):
        self.criteria, self.stopped, self.tampered, self.skipped = {}, {}, [], []

    def of(self, exercise):
        """{number of the statement: (met, what was said)}."""
        return {number: result for (name, number), result in self.criteria.items() if name == exercise}

    def take(self, line):
        if "exercise" in line:
            self.criteria[line["exercise"], line["number"]] = (line["passed"], line["said"])
        elif "stopped" in line:
            self.stopped[line["stopped"]] = line["said"]
        elif "tampered" in line and line["said"] not in self.tampered:
            self.tampered.append(line["said"])


def run_one(key, cells, student, library, forbidden):
    """Run one submission, in a process of its own, as often as it takes to get past cells that end or hang it."""
    skip, began = [], time.monotonic()
    while True:
        report, done, at = run_once(key, cells, student, library, forbidden, skip)
        report.skipped = skip
        if done:
            return report
        if not at or at in skip or time.monotonic() - began > STUDENT_TIMEOUT_S:
            report.tampered.append("the run ended before its results were complete")
            return report
        skip.append(at)


def run_once(key, cells, student, library, forbidden, skip):
    """(report, did it reach its end?, the cell or criterion at which it did not)."""
    report, nonce, at, seen = Report(), secrets.token_hex(16), "", time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder, "work")
        scratch.mkdir()
        results = Path(tempfile.mkdtemp(dir=folder), secrets.token_hex(8))
        results.touch()
        secret = [str(ROOT), str(results.parent), "/proc", *map(str, forbidden)]
        job = {"chapter": key["chapter"], "exercises": key["exercises"], "student": cells, "skip": skip,
               "nonce": nonce, "results": str(results), "library": str(library), "packages": packages(),
               "forbidden": {"roots": secret, "except": [str(VENV), str(library), str(SANDBOX)],
                             "own": [str(scratch)], "libraries": [str(library), *packages()]}}  # fmt: skip
        process = subprocess.Popen([sys.executable, "-I", "-S", "-B", str(SANDBOX)], cwd=scratch, stdin=subprocess.PIPE,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, close_fds=True,
                                   env=variables(scratch, student), start_new_session=True)  # fmt: skip
        process.stdin.write(json.dumps(job).encode())
        process.stdin.close()
        try:
            read, done, ended, lines = 0, False, False, []
            while not done and not ended and time.monotonic() - seen < CELL_TIMEOUT_S:
                ended = process.poll() is not None
                with contextlib.suppress(OSError):  # a student may have taken the file away
                    lines = results.read_bytes().split(b"\n")[:-1]
                for line in parsed(lines[read:], nonce, report):
                    at, seen = line.get("at", at), time.monotonic()
                    done = done or "done" in line
                    report.take(line)
                read = len(lines)
                time.sleep(0 if done or ended else POLL_S)
        finally:
            stop(process)
    return report, done, at


def parsed(lines, nonce, report):
    """The lines that the grader wrote; others are somebody else's, and that is said."""
    for line in lines:
        try:
            found = json.loads(line)
            if secrets.compare_digest(found["nonce"], nonce):
                yield found
                continue
        except (ValueError, KeyError, TypeError):
            pass
        report.take({"tampered": True, "said": "somebody wrote into the grader's results"})


def stop(process):
    """End the process and all that it started."""
    if os.name == "posix":
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, 9)
    else:
        process.kill()
    process.wait()


def variables(scratch, student):
    kept = {name: os.environ[name] for name in ("PATH", "LANG", "SYSTEMROOT") if name in os.environ}
    temporary = dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(scratch))
    return {**kept, **temporary, "HOME": str(scratch), "OMX_STUDENT": student, "OMX_VIEW": "data", "MPLBACKEND": "Agg",
            "MPLCONFIGDIR": str(scratch), "OMX_GENERATED": str(scratch / "generated"), "PYTHONHASHSEED": "0",
            "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}  # fmt: skip


def packages():
    """The folders of the installed packages, without links to this book."""
    return list(dict.fromkeys(sysconfig.get_path(name) for name in ("purelib", "platlib")))


def copied_library(folder):
    """A copy of `omx`, compiled, away from the chapters and their solutions; the folder that holds it."""
    shutil.copytree(ROOT / "omx", folder / "omx", ignore=shutil.ignore_patterns("*.pyc.*"))  # somebody compiles it now
    return folder
