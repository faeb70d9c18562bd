"""Reading scenes in tests: what a page would have, from the messages that it gets."""

import base64
import gzip
import json
import struct

import numpy as np
import umsgpack


def decoded(channel):
    """The channel's log, unpacked: `(type, path, property)` -> command."""
    return {key: umsgpack.unpackb(data) for key, data in channel.log.items()}


def placed(channel, path):
    """The transform of a node as a 4x4 array in mm; the identity if it was never moved."""
    command = decoded(channel).get(("set_transform", path, ""))
    matrix = np.eye(4) if command is None else np.array(command["matrix"]).reshape(4, 4).T
    matrix[:3, 3] *= 1e3
    return matrix


def objects(channel, root):
    """The paths below `root` that hold an object."""
    return {path for kind, path, _ in channel.log if kind == "set_object" and path.startswith(root)}


def bounds(channel, path):
    """The box around the solids of a node, in its own frame, mm: two corners (3,)."""
    lowered = decoded(channel)["set_object", path, ""]["object"]
    meshes = zip(lowered["geometries"], lowered["object"]["children"], strict=False)
    parts = [
        np.frombuffer(geometry["data"]["attributes"]["position"]["array"].data, "<i2").reshape(-1, 3) * child["scale"]
        for geometry, child in meshes
    ]
    return 1e3 * np.vstack(parts).min(axis=0), 1e3 * np.vstack(parts).max(axis=0)


def take_apart(text):
    """Bytes by their keys, as `static_scene.js` reads them from a packed text; where only a name stands, that name."""
    data = gzip.decompress(base64.b64decode(text))
    (size,) = struct.unpack("<I", data[:4])
    at, out = 4 + size, {}
    for *key, last in json.loads(data[4:at]):
        length = 0 if isinstance(last, str) else last
        out[tuple(key)] = last if isinstance(last, str) else data[at : at + length]
        at += length
    assert at == len(data)
    return out


class Page:
    """A page: collects messages as the notebook's JavaScript does, and keeps the state of the scene."""

    def __init__(self, channel):
        self.messages = []
        self.state = {}
        channel.attach(self.take)
        self.take(*channel.replay())

    def take(self, content, buffers):
        self.messages.append(content)
        data, at = buffers[0], 0
        if content.get("replay"):
            self.state = {}
        for (kind, path, name), size in zip(content["keys"], content["sizes"], strict=True):
            self.apply(kind, path, name, bytes(data[at : at + size]))
            at += size
        assert at == len(data)

    def apply(self, kind, path, name, data):
        if kind == "delete":
            self.state = {k: v for k, v in self.state.items() if k[1] != path and not k[1].startswith(path + "/")}
        else:
            self.state[kind, path, name] = data


class Clock:
    """A clock that stands still until a test moves it."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now
