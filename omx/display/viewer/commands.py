"""MeshCat's commands as bytes: what `meshcat.commands` lowers to, packed the same way, but faster for poses.

Nothing here imports `meshcat`: its Python side needs pyzmq and tornado, which a notebook in the browser
does not have. Only its viewer is needed, and that is a file.
"""

import functools
import math

import numpy as np
import umsgpack

_FLOAT64 = 0xCB
_NUMBER = np.dtype([("code", "u1"), ("value", ">f8")])
_TO_M = np.array([[1.0, 1.0, 1.0, 1e-3]] * 3 + [[1.0] * 4])
#: msgpack extension codes that the viewer turns into typed arrays.
TYPED = {"int8": 0x11, "uint8": 0x12, "int16": 0x13, "uint16": 0x14, "uint32": 0x16, "float32": 0x17}


def plain(value):
    """`value` with every NumPy scalar and array inside replaced by plain numbers, which msgpack accepts."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    return value


def typed(array) -> umsgpack.Ext:
    """A NumPy array as a typed array of the viewer: half the bytes of a list and no parsing."""
    return umsgpack.Ext(TYPED[array.dtype.name], np.ascontiguousarray(array).tobytes())


def attribute(array, normalized: bool = False) -> dict:
    """A vertex attribute (n, k), or an index (n,), in the viewer's JSON."""
    size = 1 if array.ndim == 1 else array.shape[1]
    kind = f"{array.dtype.name.capitalize()}Array"
    return {"itemSize": size, "type": kind, "array": typed(array), "normalized": normalized}


def pack(kind: str, path: str, **more) -> bytes:
    """One command to the node at `path`."""
    return umsgpack.packb({"type": kind, "path": path, **more})


def set_transform(path: str, T) -> bytes:
    """A `set_transform` to the rigid or stretched `T` (4, 4), mm: the viewer wants metres, column by column."""
    numbers = np.empty(16, _NUMBER)
    numbers["code"], numbers["value"] = _FLOAT64, (T * _TO_M).T.ravel()
    return _transform_head(path) + numbers.tobytes()


@functools.lru_cache(maxsize=1024)
def _transform_head(path: str) -> bytes:
    """Everything of a `set_transform` but its 16 numbers: it never changes."""
    return pack("set_transform", path, matrix=[0] * 16)[:-16]


# ---- animations: the frames of a motion as keyframe tracks that the viewer plays by itself ---------------------


def play(paths: dict, seconds: float, loop: bool) -> bytes:
    """A `set_animation` command. `paths` maps a node to its poses, (N, 4, 4) in mm, spread over `seconds`."""
    animations = [{"path": path, "clip": _clip(np.array(poses), seconds)} for path, poses in paths.items()]
    options = {"play": True, "repetitions": math.inf if loop else 1}
    return pack("set_animation", "", animations=animations, options=options)


def stop_playing() -> bytes:
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
    turned, trace = m.swapaxes(1, 2), np.trace(m, axis1=1, axis2=2)
    products = np.empty((len(m), 4, 4))  # four times those of every two components
    products[:, :3, :3] = m + turned + (1 - trace)[:, None, None] * np.eye(3)
    products[:, 3, :3] = products[:, :3, 3] = (m - turned)[:, (2, 0, 1), (1, 2, 0)]
    products[:, 3, 3] = 1 + trace
    # The row of the largest component: to divide by that one never loses digits.
    out = products[np.arange(len(m)), np.einsum("nii->ni", products).argmax(axis=1)]
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    flips = np.sign(np.einsum("ij,ij->i", out[1:], out[:-1]))
    out[1:] *= np.cumprod(np.where(flips < 0, -1.0, 1.0))[:, None]
    return out
