"""What surrounds the arm: camera, lights and ground."""

import math
from enum import Enum

import numpy as np

from ...arrays import shown
from ...errors import BadInput
from .threejs import Drawing

CAMERA = "/Cameras/default/rotated/<object>"
#: Narrow, so that parallel beams look parallel.
_FIELD_OF_VIEW = 28
#: Directions and strengths of the two lamps; the first one casts the shadows.
LAMPS = (((0.55, -0.75, 1.3), 0.62), ((-0.9, 0.6, 0.7), 0.28))
_THEIR_LAMPS = ("PointLightNegativeX", "PointLightPositiveX", "AmbientLight", "FillLight")


class Camera(Enum):
    """From where the scene is seen: the direction from the scene to the camera, x forward, y left, z up."""

    ISO = (0.74, -0.92, 0.52)
    SIDE = (0.0, -1.0, 0.06)
    FRONT = (1.0, 0.0, 0.12)
    TOP = (0.0, -0.002, 1.0)

    @classmethod
    def _missing_(cls, value):
        """A camera by its name, `"top"`; `BadInput` names all four."""
        found = cls.__members__.get(value.upper()) if isinstance(value, str) else None
        if found is None:
            names = ", ".join(f"omx.Camera.{name}" for name in cls.__members__)
            raise BadInput(f"`camera` must be one of {names}; got {shown(value)}.")
        return found

    def place(self, aim, distance: float) -> dict:
        """`position` and `target` (m) of a camera that looks at `aim` (3,) from `distance`, in MeshCat's y-up axes."""
        position = np.array(self.value) / np.linalg.norm(self.value) * distance + aim
        return {"target": _y_up(aim), "position": _y_up(position)}


def fitting(half_height: float) -> float:
    """How far (m) a camera must be to see so much (m) above and below its aim, with a margin of a tenth."""
    return 1.1 * half_height / math.tan(math.radians(_FIELD_OF_VIEW / 2))


def set_camera(channel, camera: Camera, aim, distance: float) -> None:
    """Look at `aim` (3,) from `distance`, both in metres.

    `target` is a property that our `scene.js` hands to the viewer's controls, which no command reaches.
    """
    with channel.batch():
        for name, value in {"fov": _FIELD_OF_VIEW, **camera.place(aim, distance)}.items():
            channel.set(CAMERA, name, value)


def set_light(channel) -> None:
    """Soft light from above and our lamps, instead of the viewer's own."""
    shadow = {"camera": {"type": "OrthographicCamera", "uuid": "c", "left": -0.5, "right": 0.5, "top": 0.55,
                         "bottom": -0.45, "near": 0.2, "far": 3.0, "zoom": 1},
              "mapSize": [1024, 1024], "radius": 3.5, "bias": -0.0006, "normalBias": 0.004}  # fmt: skip
    lights = Drawing()
    lights.plain("HemisphereLight", color=0xFFFFFF, groundColor=0xAFABA4, intensity=0.6)
    for (position, intensity), more in zip(LAMPS, ({"castShadow": True, "shadow": shadow}, {}), strict=True):
        lights.plain("DirectionalLight", color=0xFFFFFF, position=position, intensity=intensity, **more)
    with channel.batch():
        for path in (*(f"/Lights/{name}" for name in _THEIR_LAMPS), "/Grid", "/Axes"):
            channel.set(path, "visible", False)
        channel.draw("/meshcat/lights", lights)


def set_ground(channel, height: float, half: float) -> None:
    """A grid of `half` mm each way at `height` (mm) that fades towards its rim, and the shadow of what stands on it.

    The sky, and how all this looks at night, is in `scene.js`.
    """
    points = _grid(half, half / 10)
    fade = np.clip(1 - np.hypot(*points.T) / half, 0, 1) ** 0.6
    level = np.full(len(points), height - 0.4)
    ground = Drawing().lines(np.column_stack((points, level)), [(186, 193, 201, 255 * share) for share in fade])
    ground.mesh({"type": "PlaneGeometry", "width": 1.8e-3 * half, "height": 1.8e-3 * half},
                {"type": "ShadowMaterial", "color": 0, "opacity": 0.26, "transparent": True},
                position=[0, 0, 1e-3 * height - 6e-4], receiveShadow=True)  # fmt: skip
    channel.draw("/meshcat/ground", ground)


def _grid(half: float, step: float):
    """Lines of a grid in short pieces: points (2n, 2)."""
    ticks = np.arange(-half, half + step / 2, step)
    along, across = np.meshgrid(np.stack((ticks[:-1], ticks[1:]), axis=1).ravel(), ticks)
    points = np.stack((along.ravel(), across.ravel()), axis=1)
    return np.concatenate((points, points[:, ::-1]))


def _y_up(point) -> list[float]:
    x, y, z = (float(v) for v in point)
    return [x, z, -y]
