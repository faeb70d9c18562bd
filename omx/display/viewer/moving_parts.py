"""Drawings that ride on the frames of a linkage: an arm, a ghost of one, or its triads."""

from . import commands as messages
from .channel import Channel
from .threejs import Drawing


class Figure:
    """One node a frame below `root`; `pose` moves them all in one message.

    `drawings` maps a frame's number (0 is the base) to what is fixed to it.
    """

    def __init__(self, channel: Channel, root: str, drawings: dict[int, Drawing]):
        self._channel, self._root = channel, root
        self._heads = [(i, f"{root}/{i}", messages.transform_head(f"{root}/{i}")) for i in drawings]
        self._shown = True
        with channel.batch():
            for i, path, _ in self._heads:
                put_object(channel, path, drawings[i])

    @property
    def nodes(self) -> list[tuple[int, str]]:
        """Each frame's number and the path of its node."""
        return [(i, path) for i, path, _ in self._heads]

    def pose(self, frames) -> None:
        """Move every node to its frame: `frames` as `Linkage.frames` gives them."""
        put = self._channel.put
        with self._channel.batch():
            for i, path, head in self._heads:
                put("set_transform", path, messages.set_transform(head, frames[i]))

    def show(self, shown: bool) -> None:
        """Show or hide the whole figure; its objects stay in the page."""
        if shown != self._shown:
            self._shown = shown
            put_property(self._channel, self._root, "visible", shown)

    def fade(self, opacity: float) -> None:
        """Make every surface translucent: 1 is solid."""
        put_property(self._channel, self._root, "color", [1.0, 1.0, 1.0, float(opacity)])

    def remove(self) -> None:
        """Take the figure out of the scene."""
        self._channel.put("delete", self._root, messages.delete(self._root))


def put_object(channel: Channel, path: str, drawing: Drawing) -> None:
    """Put a drawing at `path`."""
    channel.put("set_object", path, messages.set_object(path, drawing.lower()))


def put_property(channel: Channel, path: str, name: str, value) -> None:
    """Set a property of the node at `path`."""
    channel.put("set_property", path, messages.set_property(path, name, value), name)


def put_transform(channel: Channel, path: str, matrix) -> None:
    """Move the node at `path` to 16 floats, column by column, the translation in metres."""
    channel.put("set_transform", path, messages.set_transform(messages.transform_head(path), matrix))
