"""MeshCat's commands as bytes: what `meshcat.commands` lowers to, packed the same way, but faster for poses.

Nothing here imports `meshcat`: its Python side needs pyzmq and tornado, which a notebook in the browser
does not have. Only its viewer is needed, and that is a file.
"""

import functools

import numpy as np
import umsgpack

_FLOAT64 = 0xCB
_NUMBER = np.dtype([("code", "u1"), ("value", ">f8")])
_TO_M = np.array([[1.0, 1.0, 1.0, 1e-3]] * 3 + [[1.0] * 4])
#: msgpack extension codes that the viewer turns into typed arrays.
_TYPED = {
    "int8": (0x11, "Int8Array"),
    "uint8": (0x12, "Uint8Array"),
    "int16": (0x13, "Int16Array"),
    "uint16": (0x14, "Uint16Array"),
    "uint32": (0x16, "Uint32Array"),
    "float32": (0x17, "Float32Array"),
}


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
    code, _ = _TYPED[array.dtype.name]
    return umsgpack.Ext(code, np.ascontiguousarray(array).tobytes())


def attribute(array, normalized: bool = False) -> dict:
    """A vertex attribute (n, k), or an index (n,), in the viewer's JSON."""
    size = 1 if array.ndim == 1 else array.shape[1]
    kind = _TYPED[array.dtype.name][1]
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
