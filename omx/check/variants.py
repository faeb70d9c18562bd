"""Numbers of a student's own: the same for one name and exercise every time, others for another name."""

import hashlib
import os
import unicodedata

import numpy as np

#: Holds the student's name; a grader sets it. Without it everybody has the numbers of the printed book.
STUDENT = "OMX_STUDENT"


def variant(exercise: str, student: str | None = None) -> np.random.Generator:
    """A random generator for the numbers of one exercise, such as "4.3", seeded by the student's name.

    Without a name the numbers are always the same: those that the book prints. Upper case, accents typed in two
    ways and blanks around a name make no difference. A check recomputes its answer from the numbers drawn.
    """
    name = student if student is not None else os.environ.get(STUDENT, "")
    key = f"{exercise}\0{plain(name)}".encode()
    return np.random.default_rng(int.from_bytes(hashlib.sha256(key).digest()[:8], "big"))


def plain(name: str) -> str:
    """A name as it is compared: one form for each letter, lower case, single blanks."""
    return " ".join(unicodedata.normalize("NFKC", name).casefold().split())
