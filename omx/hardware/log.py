"""Samples of a motion, written while it happens and read back without loss: CSV, one unit in each heading.

A log is a text file. Lines that begin with `#` say what it is and which geometry was used; then come a heading
with a unit for each column and one line a sample, every number in full precision.
"""

import csv
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..errors import BadInput, LogError
from ..generated.fk import PARAMETERS
from ..geometry import COURSE, Geometry

FORMAT = "omx log, format 1"


@dataclass
class Log:
    """Columns with units, and samples: `log["q1"]` is an array; `log.units["q1"]` is "deg"."""

    columns: tuple[str, ...]
    units: dict[str, str]
    samples: list[tuple[float, ...]] = field(default_factory=list)
    geometry: Geometry = COURSE
    notes: dict[str, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.samples)

    def __getitem__(self, column: str) -> np.ndarray:
        if column not in self.columns:
            raise BadInput(f"this log has no column `{column}`; it has {', '.join(self.columns)}.")
        position = self.columns.index(column)
        return np.array([sample[position] for sample in self.samples], dtype=float)

    def array(self, *columns: str) -> np.ndarray:
        """Several columns side by side, (N, k)."""
        return np.column_stack([self[c] for c in columns])


class Recorder:
    """Writes samples to `path` one by one; each line is on the disk before the next sample is taken.

    `columns` maps names to units. Use it in a `with` block; `log` has the samples, whatever happens to the file.
    An existing file is kept: the name gets a number.
    """

    def __init__(self, path, columns: Mapping[str, str], geometry: Geometry = COURSE, **notes: str):
        self.log = Log(tuple(columns), dict(columns), [], geometry, {k: str(v) for k, v in notes.items()})
        self.path = _unused(Path(path))
        try:
            self._file = self.path.open("x", encoding="utf-8", newline="")
            self._file.write(_heading(self.log))
            self._file.flush()
        except OSError as error:
            raise LogError(
                f"cannot write {self.path.name}: {error.strerror}. Choose another folder or name."
            ) from error

    def write(self, *values: float) -> None:
        """Add one sample, a number for each column; NaN stands for a value that was not measured."""
        if len(values) != len(self.log.columns):
            raise BadInput(
                f"a sample has {len(self.log.columns)} values ({', '.join(self.log.columns)}); got {len(values)}."
            )
        sample = tuple(float(v) for v in values)
        self.log.samples.append(sample)
        try:
            self._file.write(",".join(map(repr, sample)) + "\n")
            self._file.flush()
        except OSError as error:
            raise LogError(
                f"{self.path.name}: {error.strerror} after {len(self.log) - 1} samples on the disk. All "
                f"{len(self.log)} samples are kept in memory: make room, then `write_log(recorder.log, path)`.",
                self.log.samples,
            ) from error

    def close(self) -> None:
        """Close the file; closing twice is fine. A disk that is full at this moment does not hide the samples."""
        try:
            self._file.close()
        except OSError as error:
            raise LogError(
                f"{self.path.name}: {error.strerror}. The samples are kept in memory.", self.log.samples
            ) from error

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(self, kind, *_) -> None:
        try:
            self.close()
        except LogError:
            if kind is None:
                raise


class ProgressBar:
    """Draws `[########............]  40 %` in a terminal or a notebook; call it with the share done, 0 .. 1.

    Each call draws over the one before, on one line; 1 ends the line. Where nothing can be drawn over (a file, a
    pipe) only the end is written. A stream that cannot be written to is no reason to stop what is being done.
    """

    def __init__(self, text: str = "", width: int = 40, stream=None):
        self.text, self.width, self._stream, self._drawn = text, width, stream or sys.stdout, ""
        in_notebook = type(self._stream).__module__.startswith("ipykernel")
        self._live = in_notebook or bool(getattr(self._stream, "isatty", bool)())

    def __call__(self, share: float) -> None:
        share = min(max(float(share), 0.0), 1.0)
        full = math.floor(share * self.width + 1e-9)
        line = f"{self.text}[{'#' * full}{'.' * (self.width - full)}] {math.floor(100 * share + 1e-9):3d} %"
        if line != self._drawn and (self._live or share == 1.0):
            self._drawn = line
            self._write(("\r" if self._live else "") + line + ("\n" if share == 1.0 else ""))

    def _write(self, text: str) -> None:
        try:
            self._stream.write(text)
            self._stream.flush()
        except (OSError, ValueError):  # closed, or a pipe that nobody reads
            self._live = False


def progress_bar(text: str = "", width: int = 40) -> ProgressBar:
    """A progress bar for `Robot.log(..., progress=progress_bar())` and for loops of your own."""
    return ProgressBar(text, width)


def write_log(log: Log, path) -> Path:
    """Write a whole log at once; returns the path used (an existing file is kept: the name gets a number)."""
    recorder = Recorder(path, log.units, log.geometry, **log.notes)
    with recorder:
        for sample in log.samples:
            recorder.write(*sample)
    return recorder.path


def read_log(path) -> Log:
    """Read a log back: the same columns, units, geometry, notes and, to the last bit, numbers.

    A last line cut short by a power failure is left out; any other damage raises `LogError` with its line number.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise LogError(f"cannot read {path.name}: {error}") from error
    lines = text.split("\n")
    facts = _facts([line for line in lines if line.startswith("#")], path)
    body = [(i, line) for i, line in enumerate(lines, start=1) if line and not line.startswith("#")]
    if not body:
        raise LogError(f"{path.name} has no heading with column names.")
    units = _units(body[0][1])
    log = Log(tuple(units), units, [], facts.pop("geometry"), facts)
    whole = body[1:] if text.endswith("\n") else body[1:-1]
    for number, line in whole:
        log.samples.append(_sample(line, len(units), path, number))
    return log


def _heading(log: Log) -> str:
    lengths = zip(PARAMETERS, log.geometry.values, strict=True)
    geometry = ", ".join(f"{name}={value!r}" for name, value in lengths)
    lines = [f"# {FORMAT}", f"# geometry: {log.geometry.name}: {geometry}"]
    lines += [f"# {key}: {value}" for key, value in log.notes.items()]
    lines.append(",".join(f"{name} ({log.units[name]})" for name in log.columns))
    return "\n".join(lines) + "\n"


def _facts(comments: Sequence[str], path: Path) -> dict:
    if not comments or comments[0] != f"# {FORMAT}":
        raise LogError(f"{path.name} is not an omx log: its first line must be `# {FORMAT}`.")
    facts: dict = {"geometry": COURSE}
    for line in comments[1:]:
        key, _, value = line[2:].partition(": ")
        facts[key] = value
        if key == "geometry":
            name, _, lengths = value.rpartition(": ")
            facts[key] = Geometry(name, **{k: float(v) for k, v in (p.split("=") for p in lengths.split(", "))})
    return facts


def _units(heading: str) -> dict[str, str]:
    units = {}
    for cell in next(csv.reader([heading])):
        name, _, unit = cell.partition(" (")
        units[name] = unit.removesuffix(")")
    return units


def _sample(line: str, wanted: int, path: Path, number: int) -> tuple[float, ...]:
    try:
        values = tuple(float(cell) for cell in line.split(","))
    except ValueError:
        raise LogError(f"{path.name}, line {number}: not numbers: {line[:60]!r}.") from None
    if len(values) != wanted:
        raise LogError(f"{path.name}, line {number}: {len(values)} values where the heading names {wanted}.")
    return values


def _unused(path: Path) -> Path:
    """`path`, or `name-2.csv`, `name-3.csv` ... if that exists: a log is never overwritten."""
    candidate, i = path, 2
    while candidate.exists():
        candidate = path.with_name(f"{path.stem}-{i}{path.suffix}")
        i += 1
    return candidate
