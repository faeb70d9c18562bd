"""The tool's trail: a line that grows with each pose, in short pieces so that each update stays small."""

import math

from .annotations import polyline
from .channel import Channel

_SPACING = 1.5  # mm between two points
_PIECE = 16  # points in a piece


class Trail:
    """Follows a point through the scene; `add` is cheap when the point has hardly moved."""

    root = "/meshcat/trail"

    def __init__(self, channel: Channel):
        self._channel = channel
        self._points: list[tuple] = []
        self._piece = 0

    def add(self, point) -> None:
        """Go on to `point` (3,), mm."""
        if self._points and math.dist(self._points[-1], point) < _SPACING:
            return
        self._points.append(tuple(point))
        if len(self._points) < 2:
            return
        self._channel.draw(f"{self.root}/{self._piece}", polyline(self._points))
        if len(self._points) == _PIECE:
            self._points, self._piece = self._points[-1:], self._piece + 1

    def clear(self) -> None:
        """Forget the trail and start again at the next point."""
        self._points, self._piece = [], 0
        self._channel.delete(self.root)
