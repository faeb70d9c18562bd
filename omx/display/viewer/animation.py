"""Animations: the frames of a motion as keyframe tracks that the viewer plays by itself."""

import math

import numpy as np

from .commands import pack, typed


def play(paths: dict, seconds: float, loop: bool) -> bytes:
    """A `set_animation` command. `paths` maps a node to its poses, (N, 4, 4) in mm, spread over `seconds`."""
    animations = [{"path": path, "clip": _clip(np.array(poses), seconds)} for path, poses in paths.items()]
    options = {"play": True, "repetitions": math.inf if loop else 1}
    return pack("set_animation", "", animations=animations, options=options)


def nothing() -> bytes:
    """A `set_animation` that ends the one that is playing."""
    return pack("set_animation", "", animations=[], options={"play": False})


def _clip(poses, seconds: float) -> dict:
    times = np.linspace(0, seconds, len(poses)).astype(np.float32)
    position = (1e-3 * poses[:, :3, 3]).astype(np.float32)
    turn = quaternions(poses[:, :3, :3]).astype(np.float32)
    tracks = [_track("position", "vector3", times, position), _track("quaternion", "quaternion", times, turn)]
    return {"fps": 1, "name": "default", "tracks": tracks}


def _track(name: str, kind: str, times, values) -> dict:
    return {"name": f".{name}", "type": kind, "times": typed(times), "values": typed(values.ravel())}


def quaternions(rotations):
    """Unit quaternions (N, 4), x y z w, of rotation matrices (N, 3, 3), with no jump of sign between neighbours."""
    m = np.asarray(rotations, float)
    xx, yy, zz = m[:, 0, 0], m[:, 1, 1], m[:, 2, 2]
    # The four squares tell which component is largest; dividing by that one never loses digits.
    squares = np.stack((1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz, 1 + xx + yy + zz), axis=1)
    a, b, c = m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]
    d, e, f = m[:, 1, 0] + m[:, 0, 1], m[:, 0, 2] + m[:, 2, 0], m[:, 2, 1] + m[:, 1, 2]
    rows = np.stack((np.stack((squares[:, 0], d, e, a), 1), np.stack((d, squares[:, 1], f, b), 1),
                     np.stack((e, f, squares[:, 2], c), 1), np.stack((a, b, c, squares[:, 3]), 1)), axis=1)  # fmt: skip
    out = rows[np.arange(len(m)), squares.argmax(axis=1)]
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    flips = np.sign(np.einsum("ij,ij->i", out[1:], out[:-1]))
    out[1:] *= np.cumprod(np.where(flips < 0, -1.0, 1.0))[:, None]
    return out
