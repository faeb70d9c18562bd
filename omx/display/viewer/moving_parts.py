"""Drawings that ride on the frames of a chain: an arm, a ghost of one, or its triads."""

from .channel import Channel
from .threejs import Drawing


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

    def fade(self, opacity: float) -> None:
        """Make every surface translucent: 1 is solid."""
        self._channel.set(self._root, "color", [1.0, 1.0, 1.0, float(opacity)])

    def remove(self) -> None:
        """Take the figure out of the scene."""
        self._channel.delete(self._root)
