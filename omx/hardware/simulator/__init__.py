"""A virtual OpenMANIPULATOR-X behind the wire: it speaks the servos' own protocol, byte for byte.

`VirtualArm` is the mechanics and the five servos; `VirtualPort` is a port to it inside this process; and
`python -m omx.hardware.simulator` serves it to other programs.
"""

from ..clock import Clock, SteppedClock
from .virtual_arm import VirtualArm
from .virtual_port import VirtualPort

__all__ = ["Clock", "SteppedClock", "VirtualArm", "VirtualPort"]
