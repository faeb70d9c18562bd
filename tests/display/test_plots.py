"""Figures: what is drawn stands where the kinematics says, every axis has a unit, and the alt text tells it all."""

import io
import math
import re
import subprocess
import sys

import matplotlib.image
import numpy as np
import pytest

import omx
from omx.display import plots
from omx.display.palette import PALETTE

Q = (0.3, -0.4, 0.5, 0.2)
ARM = np.array([[0, 0], [1, 1.732], [0, 3.464], [-1, 3.464]])
SQUARE = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
GRID = np.linspace(0, 1, 5)
PICTURES = {
    "planar": lambda: plots.planar([ARM, -ARM], ["one", "other"], angles=True, target=(1, 1), path=ARM),
    "side_view": lambda: plots.side_view(Q, omx.HOME, target=(200, 100)),
    "branches": lambda: plots.side_view(*omx.ik([150, 0, 200, 0])),
    "curves": lambda: plots.curves(GRID, {"a": GRID, "b": -GRID}, "q3 (deg)", "det (mm^3)", marks=[(0.5, "half")]),
    "one curve": lambda: plots.curves(GRID, {"": GRID}, "t (s)", "q1 (deg)"),
    "cloud": lambda: plots.cloud(np.random.default_rng(0).normal(size=(500, 3)), alt="A ball of points"),
    "plane": lambda: plots.plane([SQUARE, 0.5 * SQUARE], arcs=[ARM]),
    "plane_map": lambda: plots.plane_map(GRID, GRID, np.add.outer(GRID, GRID), "share (%)", [0.2 + 0.1 * SQUARE]),
}


@pytest.fixture(params=PICTURES)
def picture(request):
    return PICTURES[request.param]()


def axes_of(picture):
    return picture.figure.axes[0]


def line_points(picture):
    """The points (n, 2) of every line that is drawn thick: the links."""
    return [line.get_xydata() for line in axes_of(picture).lines if line.get_linewidth() > 2.5]


# ---- every picture ---------------------------------------------------------------------------------------


def test_every_axis_has_a_title_with_a_unit(picture):
    axes = axes_of(picture)
    for title in (axes.get_xlabel(), axes.get_ylabel()):
        assert re.fullmatch(r".+ \(.+\)", title)


def test_the_bundle_is_a_png_with_its_alt_text(picture):
    data, metadata = picture._repr_mimebundle_()
    assert data["text/plain"] == f"Figure: {picture.alt}" == repr(picture)
    image = matplotlib.image.imread(io.BytesIO(data["image/png"]))
    shown = metadata["image/png"]
    assert shown["alt"] == picture.alt
    np.testing.assert_allclose(image.shape[:2], [2 * shown["height"], 2 * shown["width"]], atol=1)
    assert 0.005 < np.mean(image[..., :3].min(axis=2) < 0.9) < 0.9  # neither blank nor black


def test_the_alt_text_is_a_sentence_of_words_and_numbers(picture):
    assert len(picture.alt.split()) >= 8
    assert re.search(r"\d", picture.alt)
    assert picture.alt.endswith(".")
    assert "\n" not in picture.alt


@pytest.mark.parametrize("name", PICTURES)
def test_the_same_call_gives_the_same_bytes(name):
    assert PICTURES[name]().png() == PICTURES[name]().png()


def test_words_are_large_enough_to_read(picture):
    axes = axes_of(picture)
    texts = [axes.xaxis.label, axes.yaxis.label, *axes.get_xticklabels(), *axes.texts]
    assert min(text.get_fontsize() for text in texts) >= 11


def test_colours_differ_in_grey_too():
    """Neighbours in the palette differ in luminance or are told apart by dash, width or label as well."""
    assert len(set(PALETTE)) == len(PALETTE)
    drawn = [(line.get_color(), line.get_linestyle()) for line in axes_of(PICTURES["curves"]()).lines[:2]]
    assert len({colour for colour, _ in drawn}) == len({style for _, style in drawn}) == 2


def test_pyplot_and_its_global_state_are_never_loaded():
    draw = "import sys, omx.display.plots; omx.display.plots.planar([[[0, 0], [1, 1]]]).png()"
    code = f"{draw}; assert 'matplotlib.pyplot' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


# ---- what is drawn ---------------------------------------------------------------------------------------


def test_a_planar_arm_is_drawn_point_by_point():
    drawn = line_points(PICTURES["planar"]())
    np.testing.assert_allclose(drawn[0], ARM)
    np.testing.assert_allclose(drawn[1], -ARM)


@pytest.mark.parametrize("x", [(0.5, 0.7, 0.4), (-0.5, 2.9, -2.0), (3.0, 3.0, 3.0)])
def test_the_arcs_span_the_joint_angles(x):
    directions = np.cumsum(x)
    arm = np.vstack([[0, 0], np.cumsum(np.column_stack([np.cos(directions), np.sin(directions)]), axis=0)])
    arcs = axes_of(plots.planar([arm], angles=True)).patches
    spans = [math.radians(arc.theta2 - arc.theta1) for arc in arcs]
    np.testing.assert_allclose(spans, np.abs(x), atol=1e-9)


@pytest.mark.parametrize("q", [Q, omx.ZERO, omx.HOME, (2.5, 1.2, -1.3, 0.4)])
@pytest.mark.parametrize("geometry", [omx.COURSE, omx.MAKER])
def test_the_side_view_runs_through_the_frames(q, geometry):
    points = line_points(plots.side_view(q, geometry=geometry))[0]
    frames = omx.frames(q, geometry)
    r = frames[:, 0, 3] * math.cos(q[0]) + frames[:, 1, 3] * math.sin(q[0])
    np.testing.assert_allclose(np.delete(points, 2, axis=0), np.column_stack([r, frames[:, 2, 3]]), atol=1e-9)


def test_the_dog_leg_has_a_right_angle_and_24_mm():
    points = line_points(plots.side_view(Q))[0]
    up, forward = points[2] - points[1], points[3] - points[2]
    assert math.isclose(up @ forward, 0, abs_tol=1e-9)
    assert math.isclose(np.linalg.norm(forward), 24)


def test_all_branches_of_a_pose_meet_at_its_tip_and_illegal_ones_are_dashed():
    solutions = omx.ik([83.7, 0, 147.4, -0.9])
    assert all(s.reachable for s in solutions)
    assert {s.legal for s in solutions} == {True, False}
    picture = plots.side_view(*solutions)
    for points in line_points(picture):
        np.testing.assert_allclose(points[-1], [83.7, 147.4], atol=1e-9)
    dashed = [line.get_linestyle() == "--" for line in axes_of(picture).lines if line.get_linewidth() > 1.5]
    assert sum(dashed) == sum(not s.legal for s in solutions)
    assert picture.alt.count("beyond a joint limit") == sum(not s.legal for s in solutions)


def test_branches_out_of_reach_are_left_out_and_an_empty_view_says_so():
    assert len(line_points(plots.side_view(*omx.ik([250, 0, 100, 0])))) == 2
    nothing = plots.side_view(*omx.ik([600, 0, 204, 0]))
    assert line_points(nothing) == []
    assert "no branch is within reach" in nothing.alt


def test_curves_are_the_values_given():
    picture = PICTURES["curves"]()
    for line, sign in zip(axes_of(picture).lines[:2], (1, -1), strict=True):
        np.testing.assert_array_equal(line.get_xydata(), np.column_stack([GRID, sign * GRID]))
    assert "half is marked at 0.5" in picture.alt
    assert "a lies between 0 and 1" in picture.alt


def test_what_was_wanted_lies_thin_and_dark_over_what_came():
    picture = plots.curves(GRID, {"q1": GRID, "q2": -GRID}, "t (s)", "q (deg)", wanted={"q1": 2 * GRID, "q2": GRID})
    came, wanted = axes_of(picture).lines[:2], axes_of(picture).lines[2:4]
    for line, factor in zip(wanted, (2, 1), strict=True):
        np.testing.assert_array_equal(line.get_xydata(), np.column_stack([GRID, factor * GRID]))
    assert max(line.get_linewidth() for line in wanted) < 0.5 * min(line.get_linewidth() for line in came)
    assert min(line.get_zorder() for line in wanted) >= max(line.get_zorder() for line in came)
    assert [text.get_text() for text in picture.figure.legends[0].get_texts()] == ["q1", "q2", "wanted"]
    assert "q1 should lie between 0 and 2" in picture.alt


def test_a_polygon_that_runs_the_other_way_round_is_a_hole():
    picture = plots.plane([SQUARE, 0.5 * SQUARE[::-1]])
    image = matplotlib.image.imread(io.BytesIO(picture.png()))[::-1, :, :3]

    def colour(*point):
        column, row = axes_of(picture).transData.transform(point) * plots.picture.SHARPNESS * plots.picture.DPI / 100
        return image[round(row), round(column)]

    assert colour(0.75, 0.1).min() < 0.9  # filled
    assert colour(0.1, 0.1).min() > 0.99  # white


def test_a_map_of_the_plane_shows_its_values_under_its_own_titles():
    values = np.array([[1.0, np.nan], [3.0, 4.0]])
    axes = axes_of(plots.plane_map([0, 1], [0, 1], values, "share (%)", r="across (m)", z="up (m)"))
    np.testing.assert_array_equal(np.ma.filled(axes.collections[0].get_array(), np.nan).reshape(2, 2), values)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("across (m)", "up (m)")


def test_whole_numbers_have_a_colour_each_and_other_values_a_scale():
    counts = np.array([[1.0, 2.0], [np.nan, 4.0]])
    figure = plots.plane_map(GRID[:2], GRID[:2], counts, "branches").figure
    mesh, bar = figure.axes[0].collections[0], figure.axes[1]
    assert mesh.cmap.N == 4
    assert (mesh.norm.vmin, mesh.norm.vmax) == (0.5, 4.5)
    np.testing.assert_array_equal(bar.get_yticks(), [1, 2, 3, 4])
    smooth = plots.plane_map(GRID[:2], GRID[:2], counts + 0.5, "share (%)").figure
    assert smooth.axes[0].collections[0].cmap.N == 256


def test_a_map_ends_where_its_values_end():
    values = np.full((5, 5), np.nan)
    values[1:3, 2:4] = 1.5
    axes = axes_of(plots.plane_map(GRID, GRID, values, "share (%)"))
    for (low, high), (first, last) in zip((axes.get_xlim(), axes.get_ylim()), ((2, 3), (1, 2)), strict=True):
        assert GRID[first] - 0.2 < low < GRID[first]
        assert GRID[last] < high < GRID[last] + 0.2


def test_a_cloud_has_one_scale_and_no_numbers_in_its_corners():
    axes = axes_of(plots.cloud(np.random.default_rng(1).uniform((-9, -9, 0), (9, 9, 4), (300, 3))))
    axes.figure.draw_without_rendering()
    shown = [axis.get_view_interval() for axis in (axes.xaxis, axes.yaxis, axes.zaxis)]
    scales = np.ptp(shown, axis=1) / axes._box_aspect
    np.testing.assert_allclose(scales, scales[0])
    for axis, (low, high) in zip((axes.xaxis, axes.yaxis), shown, strict=False):
        ticks = axis.get_majorticklocs()
        assert len(ticks) >= 3
        assert low + 0.05 * (high - low) < ticks.min()
        assert ticks.max() < high - 0.05 * (high - low)


@pytest.mark.parametrize("wrong", [0.0, [], np.zeros((0, 4)), [1.0, 2.0], None, "points"])
@pytest.mark.parametrize(
    "draw",
    [
        plots.cloud,
        plots.planar,
        lambda value: plots.planar([value]),
        lambda value: plots.plane(arcs=[value]),
        lambda value: plots.curves(GRID, value, "x", "y"),
        lambda value: plots.curves([], {"a": value}, "x", "y"),
        plots.side_view,
        lambda value: plots.side_view(omx.HOME, value),
    ],
)
def test_what_cannot_be_drawn_is_named(draw, wrong):
    with pytest.raises(omx.BadInput, match=r"`\w+.*` must"):
        draw(wrong)
