"""A drawing: what goes to one path of the scene, lowered to the JSON that the MeshCat viewer loads."""

import base64
import html

import numpy as np

from ..palette import INK
from .commands import attribute
from .mesh import Solid

#: How a surface answers the light. Keys are three.js material properties.
METAL = {"type": "MeshPhongMaterial", "shininess": 45, "specular": 0x5A5D62, "side": 0}
#: A ghost gives way to a solid arm in the same place.
GHOST = {"type": "MeshPhongMaterial", "shininess": 10, "specular": 0x222222, "side": 0, "transparent": True,
         "polygonOffset": True, "polygonOffsetFactor": 3, "polygonOffsetUnits": 6}  # fmt: skip
FLAT = {"type": "MeshBasicMaterial", "side": 2}
#: Drawn over everything, so that axes inside a servo can be seen.
ON_TOP = {"depthTest": False, "depthWrite": False, "transparent": True}

#: Room (px) for a letter of a label: that of the widest, since labels are centred and what is too much shows nowhere.
LETTER = 52


class Drawing:
    """Solids, lines, labels and lights, in metres below and mm above, that form one node of the scene."""

    def __init__(self):
        self._parts = {"geometries": [], "materials": [], "textures": [], "images": [], "shapes": []}
        self._children: list[dict] = []

    def solid(self, solid: Solid, material=METAL, *, opacity=1.0, casts=True, receives=False, order=0) -> "Drawing":
        """Triangles in the colours of their vertices; `casts` and `receives` say what they have to do with shadows."""
        points, unit, normals, colours, index = solid.arrays()
        attributes = {"position": attribute(points), "normal": attribute(normals, normalized=True),
                      "color": attribute(colours, normalized=True)}  # fmt: skip
        geometry = {"type": "BufferGeometry", "data": {"attributes": attributes, "index": attribute(index)}}
        material = {**material, "vertexColors": True, "opacity": opacity}
        if opacity < 1:
            material["transparent"] = True
        placed = {"scale": [unit] * 3, "renderOrder": order}
        placed |= {"castShadow": casts and opacity == 1, "receiveShadow": receives}
        return self._child("Mesh", geometry, material, **placed)

    def lines(self, points, colours) -> "Drawing":
        """Separate thin lines: `points` (2n, 3) mm and `colours` (2n, 3) or, with opacity, (2n, 4) of 0..255."""
        points = (np.asarray(points, float) * 1e-3).astype(np.float32)
        attributes = {"position": attribute(points), "color": attribute(np.asarray(colours, np.uint8), True)}
        geometry = {"type": "BufferGeometry", "data": {"attributes": attributes}}
        material = {"type": "LineBasicMaterial", "vertexColors": True, "opacity": 1.0, "transparent": True}
        return self._child("LineSegments", geometry, material)

    def region(self, outline, holes, colour: int, opacity: float) -> "Drawing":
        """A filled plane figure: `outline` (n, 2) and `holes`, mm, in this node's x and y."""
        shape = {**_loop("Shape", outline), "holes": [_loop("Path", hole) for hole in holes]}
        geometry = {"type": "ShapeGeometry", "shapes": [self._add("shapes", shape)], "curveSegments": 1}
        material = {**FLAT, "color": colour, "opacity": opacity, "transparent": True, "depthWrite": False}
        return self._child("Mesh", geometry, material)

    def label(self, text: str, at, colour=INK, size=15.0) -> "Drawing":
        """Words that always face the reader, about `size` pixels tall, at `at` (3,) mm; `x_2` sets a subscript."""
        svg, ratio = _svg(text, colour)
        url = "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()
        texture = {"image": self._add("images", {"url": url})}
        material = {"type": "SpriteMaterial", "map": self._add("textures", texture), "sizeAttenuation": False, **ON_TOP}
        height = size * 1.75e-3
        placed = {"position": [float(c) * 1e-3 for c in at], "scale": [height * ratio, height, 1], "renderOrder": 20}
        return self._child("Sprite", None, material, **placed, userData={"words": text, "ink": colour})

    def plain(self, kind: str, **properties) -> "Drawing":
        """Any three.js object that needs neither geometry nor material: a light, say."""
        self._children.append({"type": kind, "uuid": self._name("o"), **properties})
        return self

    def mesh(self, geometry: dict, material: dict, **properties) -> "Drawing":
        """A mesh from three.js JSON, for what the methods above do not cover."""
        return self._child("Mesh", geometry, material, **properties)

    def lower(self) -> dict:
        """The JSON, as `meshcat.geometry.Object.lower` would give it."""
        parts = {name: part for name, part in self._parts.items() if part}
        group = {"type": "Group", "uuid": "group", "children": self._children}
        return {"metadata": {"version": 4.5, "type": "Object"}, **parts, "object": group}

    def _child(self, kind, geometry, material, **properties) -> "Drawing":
        references = {"material": self._add("materials", material)}
        if geometry is not None:
            references["geometry"] = self._add("geometries", geometry)
        return self.plain(kind, **references, **properties)

    def _add(self, where: str, item: dict) -> str:
        name = self._name(where)
        self._parts[where].append({"uuid": name, **item})
        return name

    def _name(self, prefix: str) -> str:
        return f"{prefix}{len(self._children)}-{len(self._parts.get(prefix, ()))}"


def _loop(kind: str, outline) -> dict:
    """A closed outline (n, 2), mm, as a three.js shape or path; a repeated last point is dropped."""
    points = [[float(x) * 1e-3, float(y) * 1e-3] for x, y in outline]
    if points[0] == points[-1]:
        points = points[:-1]
    pairs = zip(points, points[1:] + points[:1], strict=True)
    curves = [{"type": "LineCurve", "v1": a, "v2": b, "arcLengthDivisions": 1} for a, b in pairs]
    return {"type": kind, "curves": curves, "currentPoint": points[0], "autoClose": False, "arcLengthDivisions": 1}


def _svg(text: str, colour: str) -> tuple[str, float]:
    """The text as a picture with a pale halo, and its width over its height."""
    stem, _, low = text.partition("_")
    words = html.escape(stem) + (f'<tspan dy="10" font-size="34">{html.escape(low)}</tspan>' if low else "")
    width = 32 + LETTER * len(stem) + round(0.74 * LETTER * len(low))
    font = 'font-family="\'DejaVu Sans\',Verdana,\'Segoe UI\',Helvetica,sans-serif" font-size="46" font-weight="600"'
    halo = 'stroke="#ffffff" stroke-opacity="0.85" stroke-width="7" stroke-linejoin="round" paint-order="stroke"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="64"><text x="{width / 2}" y="44" '
        f'text-anchor="middle" {font} fill="{colour}" {halo}>{words}</text></svg>'
    ), width / 64
