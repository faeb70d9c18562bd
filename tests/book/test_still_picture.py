"""The picture of a scene that is printed: what stands in the scene stands in it, and nothing else does."""

import io

import numpy as np
import pytest
from PIL import Image

import omx
from book.publish.still_picture import Lens, poster
from omx.display.viewer import Camera, View

SIZE = 420, 760


def drawn(view):
    return np.asarray(Image.open(io.BytesIO(poster(view.channel.log, *SIZE))).convert("RGB"), int)


def changed(one, two):
    return np.abs(one - two).max(axis=2) > 40


def where(view, point):
    column, row, _ = Lens(view.channel.log, *SIZE[::-1])([np.multiply(point, 1e-3)])[0]
    return round(row), round(column)


def test_the_same_scene_gives_the_same_bytes():
    one, two = View(omx.HOME), View(omx.ZERO)
    two.q = omx.HOME
    assert poster(one.channel.log, 420) == poster(two.channel.log, 420)


@pytest.mark.parametrize("q", [omx.HOME, omx.ZERO, (1.0, -0.4, 0.2, 0.9)])
def test_the_tool_stands_where_the_formulas_say(q):
    """A ball of a mark there is seen there: over everything, whatever is in front."""
    view = View(q)
    before = drawn(view)
    view.arrow("tip", omx.pose(q)[:3], (0, 0, 1.5), colour="#ff0000", radius=4)
    rows, columns = np.nonzero(changed(before, drawn(view)))
    row, column = where(view, omx.pose(q)[:3])
    assert np.hypot(rows - row, columns - column).max() < 14
    assert len(rows) > 20


def test_what_is_hidden_or_gone_is_not_drawn():
    view = View()
    alone = drawn(view)
    view.ghosts([(1.2, 0.2, 0.2, 0.2), (-1.2, 0.2, 0.2, 0.2)])
    both = changed(alone, drawn(view)).sum()
    view.ghosts([(1.2, 0.2, 0.2, 0.2)])
    assert 300 < changed(alone, drawn(view)).sum() < 0.8 * both
    view.ghosts([])
    assert not changed(alone, drawn(view)).any()


def test_what_stands_in_front_hides_what_is_behind():
    """From the front, the arm folded towards the eye hides a line behind it; a mark is drawn over everything."""
    view = View(omx.ZERO, camera=Camera.FRONT)
    before = drawn(view)
    view.path([(-150, 0, 60), (-150, 0, 200)], colour="#ff0000", radius=3)
    behind = changed(before, drawn(view)).sum()
    view.path([(330, 0, 60), (330, 0, 200)], colour="#ff0000", radius=3)
    assert changed(before, drawn(view)).sum() > 1.3 * behind


def test_a_faded_arm_and_a_section_let_the_ground_show():
    solid, pale = View(), View()
    pale.opacity = 0.3
    assert drawn(pale).mean() > drawn(solid).mean() + 1
    view = View(camera=Camera.SIDE)
    before = drawn(view)
    square = [(150, 100), (300, 100), (300, 250), (150, 250)]
    hole = [(200, 150), (250, 150), (250, 200), (200, 200)]
    view.section((square, [hole]))
    after = drawn(view)
    filled, empty = where(view, (175, 0, 125)), where(view, (225, 0, 165))
    assert np.abs(after[filled] - before[filled]).max() > 8
    assert np.abs(after[empty] - before[empty]).max() <= 8


def test_words_are_there_with_their_subscript():
    view = View()
    before = drawn(view)
    view.label("p", "q_2", (0, 120, 250), colour="#0000ff")
    one = changed(before, drawn(view))
    view.label("p", "q", (0, 120, 250), colour="#0000ff")
    assert one.sum() > changed(before, drawn(view)).sum() > 20
