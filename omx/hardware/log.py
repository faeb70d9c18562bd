"""Samples of a motion, written while it happens and read back without loss: CSV, one unit in each heading.

A log is a text file. Lines that begin with `#` say what it is and which geometry was used; then come a heading
with a unit for each column and one line a sample, every number in full precision. A spreadsheet may save it again.
Notes are text and stay text: none can be taken for another line, or for a formula.
"""

import csv
import json
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..errors import BadInput, LogError
from ..generated.fk import PARAMETERS
from ..geometry import COURSE, Geometry

FORMAT = "omx log, format 1"
#: What stands between the cells of a spreadsheet, here or there; and what no line of text may have in it.
_SEPARATORS, _CONTROL = re.compile('[,;\t"]'), re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\ufeff]")


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

    def __init__(self, path, columns: Mapping[str, str], geometry: Geometry = COURSE, /, **notes: str):
        _check_names(columns, notes)
        self.log = Log(tuple(columns), dict(columns), [], geometry, {k: str(v) for k, v in notes.items()})
        self.path = Path(path)
        try:
            self.path = _unused(self.path)
            self._file = self.path.open("x", encoding="utf-8", newline="")
            self._file.write(_heading(self.log))
            self._file.flush()
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise LogError(f"cannot write {self.path.name}: {reason}. Choose another folder or name.") from error

    def write(self, *values: float) -> None:
        """Add one sample, a number for each column; NaN stands for a value that was not measured."""
        if len(values) != len(self.log.columns):
            raise BadInput(
                f"a sample has {len(self.log.columns)} values ({', '.join(self.log.columns)}); got {len(values)}."
            )
        try:
            sample = tuple(float(v) for v in values)
        except (TypeError, ValueError):
            raise BadInput(f"a sample is numbers ({', '.join(self.log.columns)}); got {values!r:.200}.") from None
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
    text = _text(path)
    lines = text.split("\n")
    first = next((i for i, line in enumerate(lines) if line.strip() and not line.startswith(("#", '"#'))), None)
    facts = _facts(lines[:first], path)
    if first is None:
        raise LogError(f"{path.name} has no heading with column names.")
    units = _units(lines[first], path, first + 1)
    log = Log(tuple(units), units, [], facts.pop("geometry"), facts)
    body = [(i, line) for i, line in enumerate(lines[first + 1 :], start=first + 2) if line]
    for number, line in body if text.endswith("\n") else body[:-1]:
        log.samples.append(_sample(line, len(units), path, number))
    return log


def _text(path: Path) -> str:
    """All of the file, line ends as `\\n`, without the mark that Excel puts before UTF-8."""
    try:
        data = path.read_bytes()
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise LogError(f"{path.name}, line {line}: not text in UTF-8.") from error
    except (OSError, ValueError) as error:
        raise LogError(f"cannot read {path.name}: {error}") from error


# ---- the lines before the samples ----


def _check_names(columns, notes) -> None:
    """Raise `BadInput` for names that would not come back as they are."""
    for name, unit in columns.items():
        if not re.match(r"\w", name) or _CONTROL.search(name + unit) or re.search("[()]", unit):
            raise BadInput(
                f"the column {name!r} ({unit!r}) cannot be written: a name is one line and begins with a letter, a "
                "unit has no brackets."
            )
    for name in notes:
        if name == "geometry" or not re.fullmatch(r"\w[\w .-]*", name):
            raise BadInput(f"a note cannot be called {name!r}: use letters, digits and _, and not `geometry`.")


def _heading(log: Log) -> str:
    lengths = zip(PARAMETERS, log.geometry.values, strict=True)
    geometry = ", ".join(f"{name}={value!r}" for name, value in lengths)
    lines = [f"# {FORMAT}", f"# geometry: {log.geometry.name}: {geometry}"]
    lines += [_cell(f"# {key}: {_one_line(value)}") for key, value in log.notes.items()]
    lines.append(",".join(_cell(f"{name} ({log.units[name]})") for name in log.columns))
    return "\n".join(lines) + "\n"


def _one_line(note: str) -> str:
    """A note as it is, or in quotes where it has more than one line, or odd spaces, or looks quoted already."""
    plain = note == note.strip() and not note.startswith('"') and not _CONTROL.search(note)
    return note if plain else json.dumps(note)


def _cell(text: str) -> str:
    """`text` as one cell of a table: in quotes if a spreadsheet would split it and take a part for a formula."""
    doubled = text.replace('"', '""')
    return f'"{doubled}"' if _SEPARATORS.search(text) else text


def _facts(lines: Sequence[str], path: Path) -> dict:
    comments = [(i, _whole(line)) for i, line in enumerate(lines, start=1) if line.strip()]
    if not comments or comments[0][1] != f"# {FORMAT}":
        raise LogError(f"{path.name} is not an omx log: its first line must be `# {FORMAT}`.")
    facts: dict = {}
    for number, line in comments[1:]:
        key, _, value = line[2:].partition(": ")
        if key in facts:
            raise LogError(f"{path.name}, line {number}: a second `{key}`.")
        facts[key] = _geometry(value, path, number) if key == "geometry" else _note(value)
    return {"geometry": COURSE, **facts}


def _whole(line: str) -> str:
    """A comment without the quotes and the empty cells that a spreadsheet adds."""
    line = line.rstrip(",;")
    return line[1:-1].replace('""', '"') if line.startswith('"') and line.endswith('"') else line


def _note(value: str) -> str:
    try:
        note = json.loads(value) if value.startswith('"') else value
    except ValueError:
        return value
    return note if isinstance(note, str) else value


def _geometry(value: str, path: Path, number: int) -> Geometry:
    name, _, lengths = value.rpartition(": ")
    try:
        given = {key: float(length) for key, length in (part.split("=") for part in lengths.split(", "))}
        return Geometry(name, **given)
    except (ValueError, TypeError) as error:
        raise LogError(f"{path.name}, line {number}: not a geometry: {value[:60]!r}.") from error


def _units(heading: str, path: Path, number: int) -> dict[str, str]:
    units: dict[str, str] = {}
    for cell in next(csv.reader([heading])):
        name, bracket, unit = cell.rpartition(" (")
        name, unit = (name, unit.removesuffix(")")) if bracket else (cell, "")
        if not name or name in units:
            raise LogError(f"{path.name}, line {number}: a column without a name, or two called {name!r}.")
        units[name] = unit
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
    while os.path.lexists(candidate):
        candidate = path.with_name(f"{path.stem}-{i}{path.suffix}")
        i += 1
    return candidate
