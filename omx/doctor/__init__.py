"""The doctor: why does the arm not answer, or not do what it should? It looks and tells; it never writes or moves.

    from omx.doctor import doctor
    doctor()                    # the first port with an arm; without one, the software alone
    doctor("/dev/ttyUSB0")      # or a Bus, a Port, or a Robot that is open
"""

from .examine import doctor
from .finding import Finding, Report
from .refusals import explain

__all__ = ["Finding", "Report", "doctor", "explain"]
