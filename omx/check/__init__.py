"""Checks for the exercises: they test properties, print one line when all is well, and otherwise teach.

Every check fails closed: an answer that is missing, of the wrong type, or not a number is `Wrong`.
"""

from .answers import expression, that, value
from .functions import call, configurations, derivative, function, round_trip
from .selftest import setup
from .validation import Wrong, answer
from .variants import variant

__all__ = [
    "Wrong", "answer", "call", "configurations", "derivative", "expression", "function", "round_trip", "setup", "that",
    "value", "variant",
]  # fmt: skip
