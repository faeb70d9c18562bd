"""The doctor: why does the arm not answer, or not do what it should? It looks and tells; it never writes or moves.

from . import doctor
doctor()                    # the first port with an arm; without one, the software alone
doctor("/dev/ttyUSB0")      # or a Bus, a Port, or a Robot that is open
"""

from ..fault_table import Finding
from .examination import doctor
from .report import Report

__all__ = ["Finding", "Report", "doctor"]
