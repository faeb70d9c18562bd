"""`View`: the arm, or any chain, in a scene that moves when its joint values are set."""

import math
from itertools import zip_longest

import numpy as np

from ...arm import HOME
from ...arrays import as_number, as_rows
from ...dh import Chain, as_chain, link_matrix
from ...errors import BadInput
from ...geometry import COURSE, as_geometry
from ...kinematics import pose as tool_pose
from ...kinematics import warn_if_replaced
from ..palette import PALETTE
from . import annotations, camera_and_light, commands
from .arm_data import arm_data, chain_data
from .arm_model import arm_drawings, finger_drawings, ghost_drawings, is_our_arm, reach
from .camera_and_light import Camera
from .channel import Channel
from .scene import Scene
from .threejs import Drawing

_FPS, _LONGEST = 30, 3600.0
_SECTION, _FRAMES = "/meshcat/section", "/meshcat/frames"
_FINGERS = (("left", 1), ("right", -1))
#: Mm between two points of a trail, and how many points are one piece of it: each update stays small.
_SPACING, _PIECE = 1.5, 16


class View(Scene):
    """The OpenMANIPULATOR-X at the joint values `q` (rad); the last expression of a cell shows it.

    `geometry` gives the lengths, `height` the pane's height in pixels, `camera` where it is seen from.
    Set `view.q` and the arm moves, in every output cell and browser tab that shows this view; a reader who pulls a link
    there, or drags the tool (the button `tool`), sets `view.q`. All lengths in mm, all angles in rad.
    """

    def __init__(self, q=HOME, *, geometry=COURSE, height=420, camera=Camera.ISO, plate=True):
        if geometry is COURSE:
            warn_if_replaced()
        if isinstance(geometry, Chain):
            raise BadInput(f"{geometry!r} is shown by View.of_chain; `geometry` holds the lengths of this book's arm.")
        self.geometry = as_geometry(geometry)
        floor = -8.0 if plate else 0.0
        super().__init__(height=height, camera=camera, aim=(0.075, 0.0, 0.15), distance=1.1, floor=floor)
        self._show(geometry.chain, q, plate)

    @classmethod
    def of_chain(cls, chain, q=None, *, height=420, camera=Camera.ISO) -> "View":
        """A view of any `omx.Chain`, drawn from its DH table alone; `q` has one value a joint (zeros if left out)."""
        as_chain(chain)
        view = cls.__new__(cls)
        view.geometry = None
        size = reach(chain)
        aim, distance = (0.0, 0.0, 0.25e-3 * size), 3.4e-3 * size
        Scene.__init__(view, height=height, camera=camera, aim=aim, distance=distance)
        view._show(chain, [0.0] * len(chain) if q is None else q)
        return view

    def _show(self, chain, q, plate: bool = False) -> None:
        self.chain = chain
        self._triads, self._trail = Figure(self.channel, _FRAMES, {}), None
        self.shown_frames: tuple[int, ...] = ()
        self._ghosts: list[Figure] = []
        self.has_section = self.animated = False
        self._opacity, self._gripper = 1.0, 0.0
        self.let_drag(chain.limits, handle=False)
        self.on_drag = self._dragged
        with self.channel.batch():
            self._figure = Figure(self.channel, "/meshcat/arm", arm_drawings(chain, self.geometry, plate))
            self.q = q
            for name, drawing in finger_drawings(self.geometry).items():
                self.channel.draw(f"/meshcat/arm/4/{name}", drawing)

    # -- the pose -----------------------------------------------------------------------------------------

    @property
    def q(self) -> tuple[float, ...]:
        """The joint values shown, rad (mm where prismatic). Set them to move the arm; the newest always wins."""
        return self._q

    @q.setter
    def q(self, value) -> None:
        q = self.check(value)
        with self.channel.batch():
            self._stop()
            self._q = q
            frames = self.chain.frames(q)
            self._figure.pose(frames)
            self._triads.pose(frames)
            if self.has_section:
                self.channel.place(_SECTION, _upright(q[0]))
            if self._trail is not None:
                self._trail.add(frames[-1, :3, 3].tolist())

    @property
    def opacity(self) -> float:
        """1 is a solid arm; less lets the frames inside it show."""
        return self._opacity

    @opacity.setter
    def opacity(self, value: float) -> None:
        self._opacity = as_number(value, "opacity", "0 to 1", 0.0, 1.0)
        self.channel.set("/meshcat/arm", "color", [1.0, 1.0, 1.0, self._opacity])

    @property
    def gripper(self) -> float:
        """Travel of each finger, mm, -10 (closed) to 19 (open); the pads are 42 + 2 x apart."""
        return self._gripper

    @gripper.setter
    def gripper(self, travel: float) -> None:
        self._gripper = _travel(travel)
        with self.channel.batch():
            for name, side in _FINGERS:
                self.channel.place(f"/meshcat/arm/4/{name}", _moved(side * self._gripper))

    # -- what is drawn about the pose ---------------------------------------------------------------------

    def frames(self, *joints: int) -> None:
        """Show labelled axes of frames 0 (base) to n (tool); `frames()` hides them all."""
        for joint in joints:
            if joint not in range(len(self.chain) + 1):
                raise BadInput(f"`joints` must be frames 0 to {len(self.chain)}; got {joint!r}.")
        self.shown_frames = joints
        with self.channel.batch():
            self.channel.delete(_FRAMES)
            self._triads = Figure(self.channel, _FRAMES, {i: annotations.triad(i, self._mark) for i in joints})
            self._triads.pose(self.chain.frames(self._q))

    def bones(self) -> None:
        """Draw a line along each link, from joint to joint and over everything: first link, first of the palette."""
        for i, row in enumerate(self.chain.rows, 1):
            corner, axis = np.array((-row.a, 0.0, 0.0)), np.array((0.0, math.sin(row.alpha), math.cos(row.alpha)))
            way = [np.zeros(3), corner, corner - row.d * axis]
            way = [p for k, p in enumerate(way) if k == 0 or np.linalg.norm(p - way[k - 1]) > 1e-6]
            if len(way) > 1:
                bone = annotations.polyline(way, PALETTE[(i - 1) % len(PALETTE)], 2.4, on_top=True)
                self.channel.draw(f"/meshcat/arm/{i}/bone", bone)

    def ghosts(self, qs) -> None:
        """Translucent arms at each of `qs`, for other IK branches or a goal; `[]` removes them.

        None and branches out of reach are skipped, so `view.ghosts(omx.ik(pose))` does.
        """
        qs = [None if getattr(q, "q", q) is None else self.check(q) for q in qs]
        with self.channel.batch():
            if not qs:
                self._ghosts = []
                self.channel.delete("/meshcat/ghosts")
            for k in range(len(self._ghosts), len(qs)):
                drawings = ghost_drawings(self.chain, self.geometry, annotations.rgb(PALETTE[k % len(PALETTE)]))
                self._ghosts.append(Figure(self.channel, f"/meshcat/ghosts/{k}", drawings))
            for ghost, q in zip_longest(self._ghosts, qs):
                ghost.show(q is not None)
                if q is not None:
                    ghost.pose(self.chain.frames(q))

    def trail(self, on: bool = True) -> None:
        """Draw the tool's way from now on; `trail(False)` removes it."""
        self.channel.delete(Trail.root)
        self._trail = Trail(self.channel) if on else None
        if on:
            self.q = self._q

    def section(self, *regions) -> None:
        """Fill plane figures in the arm's (r, z) plane, mm; they turn with joint 1. `section()` removes them.

        Each region is an outline (N, 2), or a pair (outline, list of holes).
        """
        self.has_section = bool(regions)
        with self.channel.batch():
            self.channel.delete(_SECTION)
            if regions:
                self.channel.draw(_SECTION, annotations.regions(regions))
                self.channel.place(_SECTION, _upright(self._q[0]))
                outlines = [region[0] if isinstance(region, tuple) else region for region in regions]
                self._step_back(1e-3 * np.concatenate([np.asarray(outline)[:, 1] for outline in outlines]))

    def _step_back(self, z) -> None:
        """Look at the heights `z` (m) from as far as it takes to see them all."""
        distance = camera_and_light.fitting(0.5 * np.ptp(z))
        if distance > self._aim[1]:
            self._aim = (0.0, 0.0, float(0.5 * (z.min() + z.max()))), distance
            self.camera = self.camera

    def velocity_ellipse(self, seconds: float = 0.15) -> None:
        """Draw at the tool where it gets in `seconds`, pitch held, when joints 2 and 3 share a speed of 1 rad/s.

        The scene itself computes it, by the generated Jacobian: it follows sliders, drags, animations. 0 hides it.
        """
        self.channel.set("/meshcat/arm", "ellipse", as_number(seconds, "seconds", "a time in s", low=0.0))

    def animate(self, qs, seconds: float = 4.0, loop: bool = True, *, gripper=None, things=None) -> None:
        """Play the joint values `qs` (N, n), evenly spread over `seconds`; it plays on without Python.

        Between the rows the joints are interpolated. Setting `q` ends the animation; until then `q` is its first row.
        `gripper` (N,): the fingers' travel (mm); `things`: the poses (N, 4, 4) of marks by their names: `world.film()`.
        """
        seconds = as_number(seconds, "seconds", f"a time in s above 0, at most {_LONGEST:.0f}", 1e-3, _LONGEST)
        fingers = [] if gripper is None else [_travel(travel) for travel in np.ravel(gripper)]
        rows = [self.check(q) for q in qs]
        if len(rows) < 2:
            raise BadInput(f"`qs` must have at least two rows to move between; got {len(rows)}.")
        times = np.linspace(0, len(rows) - 1, max(len(rows), math.ceil(seconds * _FPS) + 1))
        joints = np.column_stack([np.interp(times, range(len(rows)), column) for column in zip(*rows, strict=True)])
        poses = self.chain.frames(joints)
        tracks = {path: poses[:, i] for i, path in (*self._figure.nodes, *self._triads.nodes)}
        if self.has_section:
            tracks[_SECTION] = [_upright(q1) for q1 in joints[:, 0]]
        if fingers:
            for name, side in _FINGERS:
                tracks[f"/meshcat/arm/4/{name}"] = [_moved(side * travel) for travel in fingers]
        for name, poses in (things or {}).items():
            if name not in self._notes:
                raise BadInput(f"`things` names {name!r}, which is not in this scene: call `view.things` first.")
            tracks[f"/meshcat/notes/{name}"] = poses
        with self.channel.batch():
            self.q = rows[0]
            self.channel.put("set_animation", "", commands.play(tracks, seconds, loop))
            self.animated = True

    def let_drag(self, limits, *, handle: bool, inverse=None) -> None:
        """Let readers drag links and tool within `limits`, `handle` shown at once; call it before the view is shown.

        `inverse`: the chain's `omx.analysis.Inverse`, by which the hand can be turned, too; without one the tool's
        position is dragged, and the joints follow by damped least squares.
        """
        self._limits, self._handle, self._inverse = limits, handle, inverse

    # -- inside -------------------------------------------------------------------------------------------

    def __repr__(self) -> str:
        if self.geometry is None:
            values = (f"{_tidy(v)} mm" if row.prismatic else f"{_tidy(math.degrees(v))} deg"
                      for v, row in zip(self._q, self.chain.rows, strict=True))  # fmt: skip
            x, y, z = map(_tidy, self.chain.fk(self._q)[:3, 3])
            return f"{self.chain.name} at ({', '.join(values)}), tool at x = {x}, y = {y}, z = {z} mm"
        angles = ", ".join(_tidy(math.degrees(v)) for v in self._q)
        *position, pitch = tool_pose(self._q, self.geometry)
        x, y, z = map(_tidy, position)
        tool = f"tool at x = {x}, y = {y}, z = {z} mm, pitch = {_tidy(math.degrees(pitch))} deg"
        return f"{self.chain.name} at q = ({angles}) deg, {tool}"

    def check(self, q) -> tuple[float, ...]:
        """`q` as plain numbers, one a joint; `BadInput` otherwise."""
        wanted = f"{len(self.chain)} finite joint values in rad (mm where prismatic)"
        return tuple(as_rows(q, "q", len(self.chain), wanted, many=False).tolist())

    def _config(self) -> dict:
        if is_our_arm(self.geometry):
            about = arm_data(self.geometry, self._limits)
        else:
            about = chain_data(self.chain, self._limits, self._inverse)
        return {**super()._config(), "arm": {**about, "handle": self._handle}}

    def _dragged(self, _pose, q) -> None:
        if q is not None:
            self.q = q

    def _stop(self) -> None:
        if self.animated:
            self.animated = False
            self.channel.put("set_animation", "", commands.stop_playing())


def _tidy(value: float) -> str:
    """One decimal, and no minus before a zero."""
    return f"{round(value, 1) + 0.0:.1f}"


def _travel(value) -> float:
    return as_number(value, "gripper", "the fingers' travel in mm, -10 (closed) to 19 (open)", -50.0, 50.0)


def _moved(by: float) -> np.ndarray:
    """A shift along z by `by` (mm)."""
    return link_matrix(0.0, by, 0.0, 0.0)


def _upright(q1: float) -> np.ndarray:
    """The (r, z) plane of an arm whose first joint is at `q1`: the node's x points outwards, its y up."""
    return link_matrix(q1, 0.0, 0.0, math.pi / 2)


# ---- what moves -----------------------------------------------------------------------------------------------


class Figure:
    """One node a frame below `root`; `pose` moves them all in one message.

    `drawings` maps a frame's number (0 is the base) to what is fixed to it.
    """

    def __init__(self, channel: Channel, root: str, drawings: dict[int, Drawing]):
        self._channel, self._root = channel, root
        #: Each frame's number and the path of its node.
        self.nodes = [(i, f"{root}/{i}") for i in drawings]
        self._shown = True
        with channel.batch():
            for i, path in self.nodes:
                channel.draw(path, drawings[i])

    def pose(self, frames) -> None:
        """Move every node to its frame: `frames` (n + 1, 4, 4), mm, as `Chain.frames` gives them."""
        with self._channel.batch():
            for i, path in self.nodes:
                self._channel.place(path, frames[i])

    def show(self, shown: bool) -> None:
        """Show or hide the whole figure; its objects stay in the page."""
        if shown != self._shown:
            self._shown = shown
            self._channel.set(self._root, "visible", shown)


class Trail:
    """A line that grows with each pose, in short pieces; `add` is cheap when the point has hardly moved."""

    root = "/meshcat/trail"

    def __init__(self, channel: Channel):
        self._channel = channel
        self._points: list[tuple] = []
        self._piece = 0

    def add(self, point) -> None:
        """Go on to `point` (3,), mm."""
        if self._points and math.dist(self._points[-1], point) < _SPACING:
            return
        self._points.append(tuple(point))
        if len(self._points) < 2:
            return
        self._channel.draw(f"{self.root}/{self._piece}", annotations.polyline(self._points))
        if len(self._points) == _PIECE:
            self._points, self._piece = self._points[-1:], self._piece + 1
