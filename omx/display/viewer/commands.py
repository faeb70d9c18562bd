"""MeshCat's commands as bytes: what `meshcat.commands` lowers to, packed the same way, but faster for poses.

Nothing here imports `meshcat`: its Python side needs pyzmq and tornado, which a notebook in the browser
does not have. Only its viewer is needed, and that is a file.
"""

import struct

import numpy as np
import umsgpack

_FLOAT64 = 0xCB
_MATRIX = struct.Struct(">" + "Bd" * 16)
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


def set_object(path: str, lowered: dict) -> bytes:
    """Put a lowered object (see `Drawing`) at `path`."""
    return umsgpack.packb({"type": "set_object", "object": lowered, "path": path})


def set_property(path: str, name: str, value) -> bytes:
    """Set one property of the node at `path`: `visible`, `color`, `position`, ..."""
    return umsgpack.packb({"type": "set_property", "path": path, "property": name, "value": plain(value)})


def delete(path: str) -> bytes:
    """Remove the node at `path` and all below it."""
    return umsgpack.packb({"type": "delete", "path": path})


def transform_head(path: str) -> bytes:
    """Everything of a `set_transform` to `path` but its 16 numbers; it never changes, so it is packed once."""
    return umsgpack.packb({"type": "set_transform", "path": path, "matrix": [0] * 16})[:-16]


def set_transform(head: bytes, m) -> bytes:
    """A `set_transform` from its head and 16 floats, column by column, the translation in metres."""
    f = _FLOAT64
    return head + _MATRIX.pack(
        f, m[0], f, m[1], f, m[2], f, m[3], f, m[4], f, m[5], f, m[6], f, m[7],
        f, m[8], f, m[9], f, m[10], f, m[11], f, m[12], f, m[13], f, m[14], f, m[15],
    )  # fmt: skip
