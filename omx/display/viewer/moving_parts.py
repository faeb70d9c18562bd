"""What moves: drawings that ride on the frames of a chain, as an arm and its ghosts do, and the trail of a tool."""

import math

from .annotations import polyline
from .channel import Channel
from .threejs import Drawing

#: Mm between two points of a trail, and how many points are one piece of it: each update stays small.
_SPACING, _PIECE = 1.5, 16


class Figure:
    """One node a frame below `root`; `pose` moves them all in one message.

    `drawings` maps a frame's number (0 is the base) to what is fixed to it.
    """

    def __init__(self, channel: Channel, root: str, drawings: dict[int, Drawing]):
        self._channel, self._root = channel, root
        #: Each frame's number and the path of its node.
        self.nodes = [(i, f"{root}/{i}") for i in drawings]
        self._shown = True
        with channel.batch():
            for i, path in self.nodes:
                channel.draw(path, drawings[i])

    def pose(self, frames) -> None:
        """Move every node to its frame: `frames` (n + 1, 4, 4), mm, as `Chain.frames` gives them."""
        with self._channel.batch():
            for i, path in self.nodes:
                self._channel.place(path, frames[i])

    def show(self, shown: bool) -> None:
        """Show or hide the whole figure; its objects stay in the page."""
        if shown != self._shown:
            self._shown = shown
            self._channel.set(self._root, "visible", shown)


class Trail:
    """A line that grows with each pose, in short pieces; `add` is cheap when the point has hardly moved."""

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
