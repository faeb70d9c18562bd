"""Checks for the exercises: they test properties, print one line when all is well, and otherwise teach.

Every check fails closed: an answer that is missing, of the wrong type, or not a number is `Wrong`.
"""

from . import notebook
from .answers import expression, handed_in, that, value
from .functions import call, configurations, function, round_trip
from .selftest import setup
from .validation import Wrong, answer
from .variants import student, variant

notebook.install()

__all__ = [
    "Wrong", "answer", "call", "configurations", "expression", "function", "handed_in", "round_trip", "setup",
    "student", "that", "value", "variant",
]  # fmt: skip
