"""What a pinhole camera sees, where a flat mark lies by its four corners, and where the camera itself hangs.

The camera's frame: z ahead along the line of sight, x to the right in the picture, y down. Pixels count from the
picture's left upper corner. Lengths in mm; `flat` are the corners of a mark in its own plane (N, 2).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from ..arrays import as_number, as_rows, shown
from ..errors import BadInput, NotIdentifiable
from ..rotation import from_vector, rigid, to_vector

#: Nearer than this (mm) nothing is in focus, and a point behind the camera is in no picture.
NEAREST = 1.0
#: What `hand_eye` fits, by name: a shift (mm) and a turn (rad) of the tag in the hand, then of the camera.
PARTS = tuple(f"{what} of the {whose}" for whose in ("tag", "camera") for what in
              ("x", "y", "z", "turn about x", "turn about y", "turn about z"))  # fmt: skip


@dataclass(frozen=True)
class Pinhole:
    """A camera without a lens: `focal` (px) ahead of its hole a picture of `size` (px), at `T_base_camera` (4, 4)."""

    T_base_camera: np.ndarray
    focal: float = 900.0
    size: tuple[int, int] = (1280, 960)

    @classmethod
    def looking(cls, eye, at, up=(1.0, 0.0, 0.0), focal: float = 900.0) -> "Pinhole":
        """One at `eye` (3,) that looks at the point `at` (3,); the direction `up` is up in its picture."""
        eye, at, up = (as_rows(v, n, 3, "three numbers", many=False) for v, n in ((eye, "eye"), (at, "at"), (up, "up")))
        ahead = _unit(at - eye, "`eye` and `at` must be two points.")
        right = _unit(np.cross(ahead, up), "`up` must not be the direction of sight.")
        T = rigid(np.column_stack((right, np.cross(ahead, right), ahead)), eye)
        return cls(T, as_number(focal, "focal", "the focal length in pixels", 1.0))

    @property
    def K(self) -> np.ndarray:
        """The matrix (3, 3) from a point in the camera's frame to its pixel, times its depth."""
        return np.array([[self.focal, 0, self.size[0] / 2], [0, self.focal, self.size[1] / 2], [0, 0, 1]])

    def project(self, points) -> np.ndarray:
        """The pixels (N, 2) of `points` (N, 3) in the base frame; `BadInput` for a point behind the camera."""
        points = as_rows(points, "points", 3, "points in mm, shape (N, 3)")
        seen = (points - self.T_base_camera[:3, 3]) @ self.T_base_camera[:3, :3]
        if (seen[..., 2] < NEAREST).any():
            raise BadInput("a point lies behind the camera, or in it: no pixel shows it.")
        return _pixels(seen, self.K)

    def sees(self, points) -> np.ndarray:
        """Which of `points` (N, 3) lie in the picture: booleans (N,)."""
        points = as_rows(points, "points", 3, "points in mm, shape (N, 3)")
        seen = (points - self.T_base_camera[:3, 3]) @ self.T_base_camera[:3, :3]
        ahead = seen[..., 2] >= NEAREST
        pixels = _pixels(np.where(ahead[..., None], seen, 1.0), self.K)
        return ahead & ((pixels >= 0) & (pixels <= self.size)).all(axis=-1)

    def on_plane(self, pixels, height: float) -> np.ndarray:
        """The points (N, 3), base frame, where the rays of `pixels` (N, 2) meet the level plane at `height` (mm)."""
        pixels = as_rows(pixels, "pixels", 2, "pixels, shape (N, 2)")
        height = as_number(height, "height", "the height of the plane in mm")
        R, eye = self.T_base_camera[:3, :3], self.T_base_camera[:3, 3]
        rays = _rays(pixels, self.K) @ R.T
        if (np.abs(rays[..., 2]) < 1e-9).any() or ((height - eye[2]) / rays[..., 2] <= 0).any():
            raise BadInput(f"a ray does not meet the plane at {height:g} mm: the camera does not look that way.")
        return eye + rays * ((height - eye[2]) / rays[..., 2])[..., None]


def homography(flat, pixels) -> np.ndarray:
    """The matrix H (3, 3) with (u, v, 1) ~ H (x, y, 1) for each point of a plane and its pixel: the direct linear way.

    `flat` (N, 2), `pixels` (N, 2), N >= 4; H is scaled to H[2, 2] = 1. Raises `BadInput` where three of four points
    are on one line.
    """
    flat, pixels = as_rows(flat, "flat", 2, "points in their plane"), as_rows(pixels, "pixels", 2, "pixels")
    if flat.shape != pixels.shape or flat.ndim != 2 or len(flat) < 4:
        raise BadInput(f"`flat` and `pixels` must be four pairs or more; got {flat.shape} and {pixels.shape}.")
    to_flat, to_pixels = _evened(flat), _evened(pixels)
    a, b = (_homogeneous(p) @ T.T for p, T in ((flat, to_flat), (pixels, to_pixels)))
    zero = np.zeros_like(a)
    rows = np.vstack((np.hstack((a, zero, -b[:, :1] * a)), np.hstack((zero, a, -b[:, 1:2] * a))))
    _, singular, directions = np.linalg.svd(rows)
    even = directions[-1].reshape(3, 3)
    if singular[7] < 1e-9 * singular[0] or abs(np.linalg.det(even)) < 1e-9:
        raise BadInput("three of the four points lie on one line: they do not fix a plane.")
    H = np.linalg.inv(to_pixels) @ even @ to_flat
    return H / H[2, 2]


def planar_pose(flat, pixels, K) -> np.ndarray:
    """T_camera_tag (4, 4): where a plane with the points `flat` (N, 2) lies whose `pixels` (N, 2) are seen.

    From the homography, then polished until the pixels fit best. Raises `BadInput`.
    """
    flat, pixels = as_rows(flat, "flat", 2, "points in their plane"), as_rows(pixels, "pixels", 2, "pixels")
    K = as_rows(K, "K", 3, "a camera's matrix (3, 3)")
    if K.shape != (3, 3) or abs(np.linalg.det(K)) < 1e-9:
        raise BadInput(f"`K` must be a camera's matrix (3, 3), `camera.K`; got shape {K.shape}.")
    H = homography(flat, _rays(pixels, K)[..., :2])
    scale = sqrt(np.linalg.norm(H[:, 0]) * np.linalg.norm(H[:, 1]))
    H = H / np.copysign(scale, H[2, 2])  # the plane is in front of the camera
    T = rigid(_nearest_rotation(np.column_stack((H[:, 0], H[:, 1], np.cross(H[:, 0], H[:, 1])))), H[:, 2])
    points = np.column_stack((flat, np.zeros(len(flat))))
    return _fitted(T[None], lambda T: _pixels(points @ T[0, :3, :3].T + T[0, :3, 3], K) - pixels)[0][0]


@dataclass(frozen=True)
class HandEye:
    """What `hand_eye` found: the `camera` at its place, `T_tool_tag` (4, 4), the RMS of the `pixels` that are left.

    `sigma` maps each of `PARTS` to its standard deviation (mm, rad).
    """

    camera: Pinhole
    T_tool_tag: np.ndarray
    pixels: float
    sigma: dict[str, float]


def hand_eye(T_base_tool, flat, pixels, camera: Pinhole) -> HandEye:
    """Where a fixed camera hangs, from pictures (N, M, 2) of a tag's points `flat` (M, 2) in the hand.

    `T_base_tool` (N, 4, 4): where the hand was. Of `camera` only focal length and size count. First the turn of the
    tag in the hand, whose axes tell it, then the shifts, then everything together until the pixels fit best. Raises
    `NotIdentifiable` where the hand turned about parallel axes only.
    """
    hands, pictures = _poses(T_base_tool, "T_base_tool"), as_rows(pixels, "pixels", 2, "pictures (N, M, 2)")
    if not isinstance(camera, Pinhole):
        raise BadInput(f"`camera` must be a Pinhole with the camera's focal length; got {shown(camera)}.")
    flat = as_rows(flat, "flat", 2, "the tag's points in its plane, shape (M, 2)")
    if pictures.shape != (len(hands), len(flat), 2):
        raise BadInput(
            f"`pixels` must have one picture (M, 2) for each of the hands (N, 4, 4); got {pictures.shape} and "
            f"{hands.shape} with {len(flat)} points."
        )
    seen = np.array([planar_pose(flat, picture, camera.K) for picture in pictures])
    T_tool_tag = _closed_form(hands, seen)
    each = hands @ T_tool_tag @ np.linalg.inv(seen)
    T_base_camera = rigid(_nearest_rotation(each[:, :3, :3].sum(axis=0)), each[:, :3, 3].mean(axis=0))
    points = _homogeneous(np.column_stack((flat, np.zeros(len(flat)))))

    def misses(both):
        T_camera_tag = np.linalg.inv(both[1]) @ hands @ both[0]
        return _pixels((T_camera_tag @ points.T)[:, :3].transpose(0, 2, 1), camera.K) - pictures

    (T_tool_tag, T_base_camera), J, left = _fitted(np.array([T_tool_tag, T_base_camera]), misses)
    noise = sqrt((left**2).sum() / (left.size - len(PARTS)))
    sigma = noise * np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
    return HandEye(replace(camera, T_base_camera=T_base_camera), T_tool_tag, float(np.sqrt((left**2).mean())),
                   dict(zip(PARTS, sigma.tolist(), strict=True)))  # fmt: skip


def motions(T) -> np.ndarray:
    """How each of the poses `T` (N, 4, 4) is seen from every later one: inv(T_j) T_i, (N (N - 1) / 2, 4, 4)."""
    T = _poses(T, "T")
    i, j = np.triu_indices(len(T), 1)
    return np.linalg.inv(T[j]) @ T[i]


def _poses(T, name: str) -> np.ndarray:
    """`T` as poses (N, 4, 4), N > 0."""
    T = as_rows(T, name, 4, "poses (N, 4, 4)")
    if T.ndim != 3 or T.shape[1:] != (4, 4):
        raise BadInput(f"`{name}` must be poses (N, 4, 4); got shape {T.shape}.")
    return T


def _closed_form(hands, seen) -> np.ndarray:
    """T_tool_tag from A X = X B, where A are motions of the hand and B those of the tag before the camera."""
    A, B = motions(hands), motions(seen)
    axes = np.array([to_vector(a[:3, :3]) for a in A])
    rest = A[:, :3, :3] - np.eye(3)
    if len(hands) < 3 or np.linalg.svd(rest.reshape(-1, 3))[1][2] < 1e-3:
        raise NotIdentifiable(("the height of the camera", "the height of the tag in the hand"))
    others = np.array([to_vector(b[:3, :3]) for b in B])
    R = _nearest_rotation(axes.T @ others)
    shifts = (B[:, :3, 3] @ R.T - A[:, :3, 3]).reshape(-1)
    return rigid(R, np.linalg.lstsq(rest.reshape(-1, 3), shifts, rcond=None)[0])


def _fitted(T, misses, rounds: int = 15):
    """Poses `T` (n, 4, 4) moved until the sum of squares of `misses(T)` is least; the last Jacobian and misses."""
    for _ in range(rounds):
        left = misses(T).ravel()
        J = np.column_stack([(misses(_moved(T, step)) - misses(_moved(T, -step))).ravel() / (2 * _STEP)
                             for step in _STEP * np.eye(6 * len(T))])  # fmt: skip
        step = np.linalg.lstsq(J, -left, rcond=None)[0]
        T = _moved(T, step)
        if np.abs(step).max() < 1e-9:
            break
    return T, J, misses(T)


_STEP = 1e-5


def _moved(T, step) -> np.ndarray:
    """Poses (n, 4, 4), each shifted and turned a little by six of the numbers in `step`, in its own frame."""
    out = T.copy()
    for i, part in enumerate(step.reshape(-1, 6)):
        out[i, :3, 3] += part[:3]
        out[i, :3, :3] = from_vector(part[3:]) @ T[i, :3, :3]
    return out


def _pixels(points, K) -> np.ndarray:
    pixels = points @ np.asarray(K, float).T
    return pixels[..., :2] / pixels[..., 2:]


def _rays(pixels, K) -> np.ndarray:
    return _homogeneous(pixels) @ np.linalg.inv(np.asarray(K, float)).T


def _homogeneous(points) -> np.ndarray:
    return np.concatenate((points, np.ones((*np.shape(points)[:-1], 1))), axis=-1)


def _evened(points) -> np.ndarray:
    """A matrix (3, 3) that moves points (N, 2) about the origin and makes them about 1 in size."""
    middle = points.mean(axis=0)
    size = np.abs(points - middle).mean() or 1.0
    return np.array([[1 / size, 0, -middle[0] / size], [0, 1 / size, -middle[1] / size], [0, 0, 1]])


def _nearest_rotation(M) -> np.ndarray:
    U, _, V = np.linalg.svd(M)
    return U @ np.diag([1, 1, np.linalg.det(U @ V)]) @ V


def _unit(vector: Sequence[float] | np.ndarray, complaint: str) -> np.ndarray:
    size = np.linalg.norm(vector)
    if size < 1e-9:
        raise BadInput(complaint)
    return np.asarray(vector) / size
