"""`Scene`: an empty stage with a camera that shows itself in a notebook or as HTML, and marks put into it."""

import os

import numpy as np

from ...arrays import as_floats, as_four, as_number, as_rows, as_word
from ...errors import BadInput
from ..palette import INK, VERMILION
from . import annotations, camera_and_light, html_export
from .assets import script
from .camera_and_light import Camera
from .channel import Channel
from .threejs import Drawing

#: Set to `data`, scenes and panels show themselves as JSON of the type `SCENE`, not as a live widget: see `page_data`.
MODE, SCENE = "OMX_VIEW", "application/vnd.omx.scene+json"


class Scene:
    """A stage with ground, light and camera; `aim` (3,) is what the camera looks at, from `distance`, both in m."""

    def __init__(self, *, height: int, camera: Camera, aim, distance: float, floor: float = 0.0):
        self.channel = Channel()
        self.height = int(as_number(height, "height", "a number of pixels", low=1.0, high=1e5))
        self._aim = aim, distance
        self._mark = 52.0 * max(0.5, distance)
        #: Called with the target to which a reader drags the tool, [x, y, z, pitch] (mm, rad) or a hand's T (4, 4), and
        #: with the joint values: no target (None) where a link was pulled, no joint values where it cannot be had.
        self.on_drag = lambda pose, q: None
        self._widget = None
        self._notes: set[str] = set()
        with self.channel.batch():
            camera_and_light.set_light(self.channel)
            camera_and_light.set_ground(self.channel, floor, 500.0 * max(0.4, distance))
            self.camera = camera

    # -- how it is seen -----------------------------------------------------------------------------------

    @property
    def camera(self) -> Camera:
        """From where the scene is seen; set it to move the camera. The reader may turn it by mouse at any time."""
        return self._camera

    @camera.setter
    def camera(self, camera: Camera) -> None:
        self._camera = Camera(camera)
        camera_and_light.set_camera(self.channel, self._camera, *self._aim)

    def _config(self) -> dict:
        """What the scene's scripts are told when they start."""
        return {"cameras": {camera.name.lower(): camera.place(*self._aim) for camera in Camera}}

    # -- marks --------------------------------------------------------------------------------------------

    def arrow(self, name: str, start, direction, *, label=None, colour=INK, radius: float = 1.6) -> None:
        """An arrow from `start` (3,) along `direction` (3,), as long as that is, mm; none where that is 0."""
        start, direction = _vector("start", start), _vector("direction", direction)
        if not direction.any():
            return self.remove(name)
        return self._note(name, annotations.arrow(start, start + direction, colour, label, _size("radius", radius)))

    def axis(self, name: str, point, direction, *, label=None, colour=VERMILION, length=None) -> None:
        """A joint's axis: the line through `point` (3,) mm along `direction` (3,), `length` mm of it drawn.

        An arc about it shows the positive turn, by the right-hand rule.
        """
        point, direction = _vector("point", point), _vector("direction", direction)
        if not direction.any():
            raise BadInput("`direction` must point somewhere: one of its three numbers must not be 0.")
        length = _size("length", length or 4.0 * self._mark)
        self._note(name, annotations.axis(point, direction, length, colour, label))

    def arc(self, name: str, centre, start, end, *, label=None, colour=INK) -> None:
        """An angle about `centre` (3,), from direction `start` (whose length is its radius, mm) to direction `end`."""
        centre, start, end = _vector("centre", centre), _vector("start", start), _vector("end", end)
        if not (start.any() and end.any()):
            raise BadInput("`start` and `end` must point somewhere: one of the three numbers must not be 0.")
        self._note(name, annotations.arc(centre, start, end, colour, label))

    def triad(self, name: str, T, *, index: int | None = None, size: float | None = None) -> None:
        """A frame `T` (4, 4) of your own; with `index` its axes are labelled x_index, y_index, z_index."""
        self._note(name, annotations.triad(index, _size("size", size or self._mark)), T)

    def label(self, name: str, text: str, at, *, colour=INK) -> None:
        """Words at the point `at` (3,) mm that always face the reader; `q_1` sets a subscript."""
        self._note(name, Drawing().label(text, _vector("at", at), annotations.as_hex(colour)))

    def path(self, points, *, name: str = "path", colour=VERMILION, radius: float = 1.2) -> None:
        """A line through `points` (N, 3) mm; a path of the same name is replaced."""
        points = np.asarray(points, float)
        if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2 or not np.isfinite(points).all():
            raise BadInput(f"`points` must be finite, shape (N, 3) with N >= 2, in mm; got shape {points.shape}.")
        self._note(name, annotations.polyline(points, colour, _size("radius", radius)))

    def things(self, things) -> None:
        """Draw what is on a table, such as `world.things`: boxes and cups. One that is there already is moved.

        Each has a `name`, `width` and `height` (mm), is `round` or not, has a `colour`, and its middle at `T` (4, 4).
        """
        with self.channel.batch():
            for one in things:
                if one.name in self._notes:
                    self.channel.place(f"/meshcat/notes/{one.name}", _matrix(one.T))
                else:
                    self._note(one.name, annotations.thing(one.width, one.height, one.round, one.colour), one.T)

    def target(self, pose) -> None:
        """Mark a target: [x, y, z, pitch] (mm, rad), or a pose (4, 4); None removes it."""
        if pose is None:
            return self.remove("target")
        matrix = _pose_matrix(pose)
        if "target" in self._notes:
            return self.channel.place("/meshcat/notes/target", matrix)
        return self._note("target", annotations.target(0.75 * self._mark), matrix)

    def remove(self, name: str) -> None:
        """Remove a mark or a path by its name; nothing happens if there is none."""
        self._notes.discard(name)
        self.channel.delete(f"/meshcat/notes/{name}")

    # -- output -------------------------------------------------------------------------------------------

    @property
    def vis(self):
        """The real `meshcat.Visualizer` of this scene (its lengths are metres, its root is `/meshcat`)."""
        from meshcat import Visualizer

        return Visualizer(window=self.channel)

    @property
    def widget(self):
        """The widget behind the output cell, to be put into boxes beside others."""
        if self._widget is None:
            from .widget import SceneWidget

            config = {"shell": html_export.shell(self._config()), "start": script("static_scene.js")}
            about = {"height": self.height, "title": repr(self), "config": config}
            self._widget = SceneWidget(self.channel, lambda *told: self.on_drag(*told), **about)
        return self._widget

    def static_html(self) -> str:
        """The scene as HTML without a kernel: sandboxed, fetching nothing, animated if an animation is set."""
        return html_export.frame(self.channel.log, self._config(), self.height, repr(self))

    def page_data(self) -> dict:
        """All that a tool needs to put the scene on a page of its own; its log is packed by `html_export.as_text`."""
        log = html_export.as_text(self.channel.log)
        return {"title": repr(self), "height": self.height, "config": self._config(), "log": log}

    def __repr__(self) -> str:
        return "3-D scene"

    def _repr_mimebundle_(self, include=None, exclude=None) -> dict:
        return mimebundle(self)

    def _note(self, name: str, drawing: Drawing, matrix=None) -> None:
        placed = None if matrix is None else _matrix(matrix)
        self._notes.add(as_word(name))
        with self.channel.batch():
            self.channel.draw(f"/meshcat/notes/{name}", drawing)
            if placed is not None:
                self.channel.place(f"/meshcat/notes/{name}", placed)


def mimebundle(shown) -> dict:
    """What a cell shows for a scene or a panel: a live widget, or data where `OMX_VIEW` asks."""
    if os.environ.get(MODE) == "data":
        return {"text/plain": repr(shown), SCENE: shown.page_data()}
    model = shown.widget if isinstance(shown, Scene) else shown
    view = {"version_major": 2, "version_minor": 0, "model_id": model.model_id}
    return {"text/plain": repr(shown), "application/vnd.jupyter.widget-view+json": view}


def _size(name: str, value) -> float:
    return as_number(value, name, "a length in mm above 0", low=1e-3, high=1e6)


def _vector(name: str, value) -> np.ndarray:
    return as_rows(value, name, 3, "three finite numbers", many=False)


def _matrix(value) -> np.ndarray:
    matrix = as_floats(value, "pose", "a pose (4, 4), in mm")
    if matrix.shape != (4, 4):
        raise BadInput(f"`pose` must be a pose (4, 4), in mm; got shape {matrix.shape}.")
    return as_rows(matrix, "pose", 4, "a pose, in mm")


def _pose_matrix(pose):
    """T_base_target of [x, y, z, pitch]: the tool lies in the vertical plane through the base axis."""
    if np.shape(pose) != (4,):
        return _matrix(pose)
    x, y, z, pitch = as_four(pose, "pose", "[x, y, z, pitch] in mm and rad")
    yaw = np.arctan2(y, x)
    c, s, cp, sp = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    return np.array([[c * cp, c * sp, -s, x], [s * cp, s * sp, c, y], [sp, -cp, 0, z], [0, 0, 0, 1]])
