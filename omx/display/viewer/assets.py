"""The MeshCat viewer as its package ships it, and our few lines that run beside it, packed for a page."""

import functools
import gzip
import hashlib
import importlib.util
from pathlib import Path

from ...errors import ViewerMissing

_HERE = Path(__file__).parent


def viewer_source() -> str:
    """The unmodified viewer, `meshcat/viewer/dist/main.min.js`. `meshcat` itself is not imported."""
    spec = importlib.util.find_spec("meshcat")
    if spec is None:
        raise ViewerMissing("no package `meshcat`")
    path = Path(spec.submodule_search_locations[0], "viewer", "dist", "main.min.js")
    if not path.is_file():
        raise ViewerMissing(path)
    return path.read_text(encoding="utf-8")


@functools.cache
def script(name: str) -> str:
    """One of our own scripts: `scene.js`, `widget.js` or `placeholders.js`."""
    return (_HERE / name).read_text(encoding="utf-8")


@functools.cache
def packed() -> tuple[str, bytes]:
    """`(key, bytes)`: the viewer and `scene.js`, gzipped; the key changes when they do."""
    source = (viewer_source() + "\n" + script("scene.js")).encode("utf-8")
    return hashlib.sha256(source).hexdigest()[:16], gzip.compress(source, 9, mtime=0)
