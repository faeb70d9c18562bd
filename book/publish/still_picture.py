"""A scene as a picture, for paper. Drawn by NumPy, so no browser is needed.

Triangles go through a depth buffer, at twice the size, and the result is halved: what the viewer's scripts draw, in
simpler light. The same scene gives the same bytes.
"""

import base64
import io
from pathlib import Path
from typing import NamedTuple

import matplotlib
import numpy as np
import umsgpack
from PIL import Image, ImageDraw, ImageFilter, ImageFont

from book.publish import scenes
from omx.display.viewer.camera_and_light import CAMERA, LAMPS
from omx.display.viewer.commands import TYPED

#: Drawn this many times larger, then made smaller: smooth edges.
FINE = 2
WIDTH = 760
COLOURS = 128
#: So many pixels are looked at together.
AT_ONCE = 1_000_000
#: The light that comes from everywhere, and how much of it a shadow takes.
SKY = 0.5
SHADOW = 0.17
_FONT = Path(matplotlib.get_data_path(), "fonts/ttf/DejaVuSans-Bold.ttf")
_DTYPES = {code: np.dtype(name).newbyteorder("<") for name, code in TYPED.items()}


class Part(NamedTuple):
    """One child of a drawing where it stands: three.js JSON, its parts by their names, and how opaque it is."""

    about: dict
    parts: dict
    place: np.ndarray
    opacity: float

    @property
    def material(self) -> dict:
        return self.parts[self.about["material"]]

    @property
    def geometry(self) -> dict:
        return self.parts[self.about["geometry"]]

    def array(self, name: str):
        return _array(self.geometry["data"]["attributes"][name])

    def on_top(self) -> bool:
        return self.material.get("depthTest") is False


class Lens:
    """The camera: points (n, 3) in metres become columns, rows, and a depth that grows away from the eye."""

    def __init__(self, log: dict, width: int, height: int):
        told = {name: umsgpack.unpackb(data)["value"] for (_, path, name), data in log.items() if path == CAMERA}
        eye, aim = (np.array([x, -z, y]) for x, y, z in (told["position"], told["target"]))  # from axes with y up
        ahead = _unit(aim - eye)
        right = _unit(np.cross(ahead, (0.0, 0.0, 1.0)))
        self.eye, self.axes = eye, np.array([right, np.cross(ahead, right), ahead])
        zoom = min(1.0, width / height / 1.25)
        self.scale = 0.5 * height * zoom / np.tan(np.radians(told["fov"]) / 2)
        self.middle = np.array([0.5 * width, 0.5 * height])

    def __call__(self, points):
        x, y, far = self.axes @ (np.asarray(points, float) - self.eye).T
        far = np.maximum(far, 1e-3)
        return np.column_stack((self.middle[0] + self.scale * x / far, self.middle[1] + self.scale * y / far, -1 / far))


class Sheet:
    """Colours (rows * columns, 3) and depths (rows * columns,) of what is drawn so far, on white."""

    def __init__(self, width: int, height: int):
        self.shape = height, width
        self.colour = np.full((height * width, 3), 255.0)
        self.depth = np.full(height * width, np.inf)

    def triangles(self, points, colours, faces, opacity: float, on_top: bool) -> None:
        """Draw triangles (m, 3) of `points` (n, 3: column, row, depth), whose corners have `colours` (n, 3)."""
        depth = np.full_like(self.depth, np.inf) if on_top else self.depth if opacity == 1 else self.depth.copy()
        layer, drawn = np.zeros_like(self.colour), np.zeros(len(depth), bool)
        for triangle, cell, far, v, w in _cells(points[faces], self.shape):
            np.minimum.at(depth, cell, far)
            seen = depth[cell] == far
            one, two, three = colours[faces[triangle[seen]]].swapaxes(0, 1)
            layer[cell[seen]] = one + v[seen, None] * (two - one) + w[seen, None] * (three - one)
            drawn[cell[seen]] = True
        self.put(np.flatnonzero(drawn), layer[drawn], opacity)

    def put(self, cells, colours, opacity) -> None:
        """Lay colours over what is there; `opacity` is one number, or one a cell (n, 1)."""
        self.colour[cells] += opacity * (colours - self.colour[cells])


def with_poster(told: dict) -> dict:
    """What a cell told of a scene (`SCENE`), with its picture, base64; of a live figure, as it is."""
    if "log" not in told:
        return told
    return {**told, "poster": base64.b64encode(poster(scenes.from_text(told["log"]), told["height"])).decode()}


def poster(log: dict, height: int, width: int = WIDTH) -> bytes:
    """The scene of a channel's `log` as a WebP picture, `width` x `height` pixels, light whatever the page's theme."""
    lens, sheet = Lens(log, FINE * width, FINE * height), Sheet(FINE * width, FINE * height)
    parts = sorted(_parts(log), key=lambda part: part.about.get("renderOrder", 0))
    meshes = [part for part in parts if part.about["type"] == "Mesh"]
    grounds, solids, shapes = (
        [part for part in meshes if part.geometry["type"] == f"{kind}Geometry"] for kind in ("Plane", "Buffer", "Shape")
    )
    _shadows(sheet, lens, [part for part in solids if part.about.get("castShadow")], grounds[0].place[2, 3])
    for part in (part for part in parts if part.about["type"] == "LineSegments"):
        _draw_lines(sheet, lens, part)
    for part in sorted(solids, key=lambda part: part.on_top() + (part.opacity < 1) / 2):
        _draw_solid(sheet, lens, part)
    for part in shapes:
        _draw_shape(sheet, lens, part)
    picture = Image.fromarray(sheet.colour.round().astype(np.uint8).reshape(*sheet.shape, 3))
    picture = picture.resize((width, height), Image.Resampling.BOX)
    small = Lens(log, width, height)
    for part in (part for part in parts if part.about["type"] == "Sprite"):
        _write(picture, small, part)
    out = io.BytesIO()
    few = picture.quantize(COLOURS, dither=Image.Dither.NONE).convert("RGB")
    few.save(out, "webp", lossless=True, method=4, quality=100)  # 6 takes fifty times as long for a thousandth
    return out.getvalue()


# ---- what there is -------------------------------------------------------------------------------------------


def _parts(log: dict):
    """Every visible child of every drawing below /meshcat."""
    told = {key: umsgpack.unpackb(data) for key, data in log.items()}
    for (kind, path, _), command in told.items():
        above = ["/".join(path.split("/")[:n]) for n in range(2, path.count("/") + 2)]
        if kind != "set_object" or any(_told(told, p, "visible", True) is False for p in above):
            continue
        place = np.eye(4)
        for parent in above:
            if moved := told.get(("set_transform", parent, "")):
                place = place @ np.reshape(moved["matrix"], (4, 4)).T
        fades = [colour[3] for p in above if (colour := _told(told, p, "color", None))]
        lowered = command["object"]
        named = {item["uuid"]: item for kept in ("geometries", "materials", "textures", "images", "shapes")
                 for item in lowered.get(kept, ())}  # fmt: skip
        for child in lowered["object"]["children"]:
            own = named.get(child.get("material"), {}).get("opacity", 1.0)
            yield Part(child, named, place @ _local(child), fades[-1] if fades else own)


def _told(told: dict, path: str, name: str, otherwise):
    return told.get(("set_property", path, name), {"value": otherwise})["value"]


def _local(child: dict):
    """The matrix (4, 4) of a child's own position and size."""
    local = np.diag([*child.get("scale", (1, 1, 1)), 1.0])
    local[:3, 3] = child.get("position", (0, 0, 0))
    return local


def _array(lowered: dict):
    packed = lowered["array"]
    values = np.frombuffer(packed.data, _DTYPES[packed.type])
    return values.reshape(-1, lowered["itemSize"]) if lowered["itemSize"] > 1 else values


# ---- how it is drawn -----------------------------------------------------------------------------------------


def _at(part: Part, points):
    return points @ part.place[:3, :3].T + part.place[:3, 3]


def _draw_solid(sheet: Sheet, lens: Lens, part: Part) -> None:
    points, faces = lens(_at(part, part.array("position").astype(float))), _faces(part)
    sheet.triangles(points, _lit(part), faces[_to_the_eye(points, faces)], part.opacity, part.on_top())


def _faces(part: Part):
    return _array(part.geometry["data"]["index"]).astype(int).reshape(-1, 3)


def _cells(corners, shape):
    """The pixels of triangles (m, 3, 3), those of one size at a time: which triangle, which cell, depth, and shares.

    The shares `v` and `w` (p,) of the second and third corner are those that make the pixel's middle.
    """
    rows, columns = shape
    low = np.ceil(corners[:, :, :2].min(axis=1) - 0.5).clip(0)
    high = np.minimum(np.floor(corners[:, :, :2].max(axis=1) - 0.5), (columns - 1, rows - 1))
    a, b, c = corners.transpose(1, 0, 2)
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    size = 2 ** np.ceil(np.log2((high - low + 1).clip(1))).astype(int)
    size[(high < low).any(axis=1) | (area == 0)] = 0
    for wide, tall in np.unique(size[size[:, 0] > 0], axis=0):
        of_size = np.flatnonzero((size == (wide, tall)).all(axis=1))
        for which in np.array_split(of_size, len(of_size) * wide * tall // AT_ONCE + 1):
            column = low[which, 0, None, None] + np.arange(wide)
            row = low[which, 1, None, None] + np.arange(tall)[:, None]
            (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corners[which].transpose(1, 2, 0)[..., None, None]
            x, y = column + 0.5 - ax, row + 0.5 - ay
            v = (x * (cy - ay) - y * (cx - ax)) / area[which, None, None]
            w = (y * (bx - ax) - x * (by - ay)) / area[which, None, None]
            inside = (v >= 0) & (w >= 0) & (v + w <= 1) & (column < columns) & (row < rows)
            far = az + v * (bz - az) + w * (cz - az)
            cell = (row * columns + column).astype(int)
            yield np.repeat(which, inside.sum(axis=(1, 2))), cell[inside], far[inside], v[inside], w[inside]


def _to_the_eye(points, faces):
    """Which faces turn their outer side to the eye, where rows count downwards."""
    a, b, c = (points[faces[:, k], :2] for k in range(3))
    return (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])


def _lit(part: Part):
    """The colours (n, 3) of the vertices under the lamps; flat materials answer no light."""
    colours = part.array("color")[:, :3].astype(float)
    if part.material["type"] == "MeshBasicMaterial":
        return colours
    normals = part.array("normal") @ part.place[:3, :3].T
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    light = SKY * (0.85 + 0.15 * normals[:, 2])
    light += sum(strength * (normals @ _unit(lamp)).clip(0) for lamp, strength in LAMPS)
    return (colours * light[:, None]).clip(0, 255)


def _shadows(sheet: Sheet, lens: Lens, solids: list[Part], floor: float) -> None:
    """The shadow of the first lamp on the ground, with a soft rim."""
    mask = Image.new("L", sheet.shape[::-1])
    pen, slope = ImageDraw.Draw(mask), np.divide(LAMPS[0][0], LAMPS[0][0][2])
    for part in solids:
        points = _at(part, part.array("position").astype(float))
        points = lens(points - (points[:, 2:] - floor) * slope)[:, :2]
        for face in points[_faces(part)].reshape(-1, 6).tolist():
            pen.polygon(face, fill=255)
    shade = np.asarray(mask.filter(ImageFilter.GaussianBlur(3 * FINE)), float)
    sheet.colour *= 1 - SHADOW / 255 * shade.reshape(-1, 1)


def _draw_lines(sheet: Sheet, lens: Lens, part: Part) -> None:
    """Separate thin lines, in pieces of a pixel."""
    ends = lens(_at(part, part.array("position"))).reshape(-1, 2, 3)
    colours = part.array("color")[::2].astype(float)
    opacity = colours[:, 3:] / 255 if colours.shape[1] == 4 else np.ones((len(colours), 1))
    count = np.ceil(np.abs(np.diff(ends, axis=1))[:, 0, :2].max(axis=1)).astype(int).clip(1, 4000)
    line = np.repeat(np.arange(len(ends)), count)
    share = (np.arange(len(line)) - np.repeat(np.cumsum(count) - count, count)) / count[line]
    dots = ends[line, 0] + share[:, None] * (ends[line, 1] - ends[line, 0])
    column, row = dots[:, :2].astype(int).T
    rows, columns = sheet.shape
    inside = (dots[:, :2] >= 0).all(axis=1) & (column < columns) & (row < rows)
    line = line[inside]
    sheet.put((row * columns + column)[inside], colours[line, :3], opacity[line])


def _draw_shape(sheet: Sheet, lens: Lens, part: Part) -> None:
    """A filled plane figure with holes, in front of what lies behind its plane."""
    shape = part.parts[part.geometry["shapes"][0]]
    mask = Image.new("L", sheet.shape[::-1])
    for loop, fill in ((shape, 255), *((hole, 0) for hole in shape["holes"])):
        outline = np.array([[*curve["v1"], 0.0] for curve in loop["curves"]])
        points = lens(_at(part, outline))
        ImageDraw.Draw(mask).polygon(points[:, :2].ravel().tolist(), fill=fill)
        if fill:
            flat = np.column_stack((points[:, :2], np.ones(len(points))))
            plane = np.linalg.lstsq(flat, points[:, 2], rcond=None)[0]
    cells = np.flatnonzero(np.asarray(mask))
    row, column = np.divmod(cells, sheet.shape[1])
    seen = plane @ (column + 0.5, row + 0.5, np.ones(len(cells))) < sheet.depth[cells]
    colour = np.array([part.material["color"] >> shift & 255 for shift in (16, 8, 0)], float)
    sheet.put(cells[seen], colour, part.opacity)


def _write(picture: Image.Image, lens: Lens, part: Part) -> None:
    """A label, over everything: its words and a smaller subscript, with a pale rim."""
    told = part.about["userData"]
    stem, _, low = told["words"].partition("_")
    size = part.about["scale"][1] / (2 * np.tan(np.arctan(0.5 * picture.height / lens.scale))) * picture.height
    ((column, row, _),) = lens(part.place[None, :3, 3])
    pieces = [(stem, 46 / 64, 0.0), (low, 34 / 64, 10 / 64)]
    fonts = [ImageFont.truetype(str(_FONT), max(6.0, share * size)) for _, share, _ in pieces]
    lengths = [font.getlength(text) for font, (text, _, _) in zip(fonts, pieces, strict=True)]
    at, pen = column - 0.5 * sum(lengths), ImageDraw.Draw(picture)
    for font, (text, _, drop), length in zip(fonts, pieces, lengths, strict=True):
        pen.text((at, row + (12 / 64 + drop) * size), text, told["ink"], font, "ls", stroke_width=2, stroke_fill="#fff")
        pen.text((at, row + (12 / 64 + drop) * size), text, told["ink"], font, "ls")
        at += length


def _unit(vector):
    return np.divide(vector, np.linalg.norm(vector))
