"""The MeshCat viewer as its package ships it, and our own scripts that run beside it, packed for a page."""

import functools
import gzip
import hashlib
import importlib.util
import re
from pathlib import Path

from ...errors import ViewerMissing

_HERE = Path(__file__).parent
_GENERATED = _HERE.parents[1] / "generated"


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
    """One of our own scripts: `scene.js`, `tool.js`, `widget.js` ..."""
    return (_HERE / name).read_text(encoding="utf-8")


def kinematics() -> str:
    """The generated formulas and `arm.js` as one plain script: pages opened from a folder may not load modules."""
    parts = []
    for path in (_GENERATED / f"{name}.js" for name in ("fk", "ik", "jacobian")):
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        parts.append(f"{path.stem}: {as_expression(text)},\n")
    return f"window.OMX_KINEMATICS = {{\n{''.join(parts)}}};\n{script('arm.js')}"


def as_expression(module: str) -> str:
    """The text of a JavaScript module as an expression: an object of all that it exports."""
    names = ", ".join(re.findall(r"^export (?:function|const) (\w+)", module, re.M))
    body = re.sub(r"^export ", "", module, flags=re.M)
    return f"(() => {{\n{body}\nreturn {{ {names} }};\n}})()"


@functools.cache
def packed() -> tuple[str, bytes]:
    """`(key, bytes)`: the viewer and what runs beside it, gzipped; the key changes when they do."""
    parts = (viewer_source(), kinematics(), *map(script, ("scene.js", "tool.js", "dh_row.js")))
    source = "\n".join(parts).encode("utf-8")
    return hashlib.sha256(source).hexdigest()[:16], gzip.compress(source, 9, mtime=0)
