"""Numbers of a student's own: the same for one name and exercise every time, others for another name."""

import hashlib
import os
import unicodedata

import numpy as np

from . import passed

#: Holds the student's name, and counts before what `student` has kept. A grader sets it; empty, it means nobody.
STUDENT = "OMX_STUDENT"


def student(name: str) -> None:
    """Keep your name beside the notebooks, on this disk: from now on the numbers of exercises are your own."""
    passed.keep_name(name)
    print(f"The numbers are those of {plain(name)!r} now." if plain(name) else "The numbers are those of the book now.")


def variant(exercise: str, student: str | None = None) -> np.random.Generator:
    """A random generator for the numbers of one exercise, such as "4.3", seeded by the student's name.

    Without a name the numbers are always the same: those that the book prints. Upper case, accents typed in two
    ways and blanks around a name make no difference. A check recomputes its answer from the numbers drawn.
    """
    name = os.environ.get(STUDENT, passed.name()) if student is None else student
    key = f"{exercise}\0{plain(name)}".encode()
    return np.random.default_rng(int.from_bytes(hashlib.sha256(key).digest()[:8], "big"))


def plain(name: str) -> str:
    """A name as it is compared: one form for each letter, lower case, single blanks."""
    return " ".join(unicodedata.normalize("NFKC", name).casefold().split())
