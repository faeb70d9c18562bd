"""The channel: the newest always wins, one message a batch, and a late page sees what an early one sees."""

import asyncio
import threading

import numpy as np
import pytest
import umsgpack
from hypothesis import given, settings
from hypothesis import strategies as st
from meshcat import Visualizer
from meshcat.geometry import Box, MeshPhongMaterial

from omx.display.viewer import channel as channels
from omx.display.viewer.channel import INTERVAL, Channel
from tests.helpers.scenes import Clock, Page, decoded

PATHS = ["/meshcat/a", "/meshcat/a/b", "/meshcat/ab", "/meshcat/c", "/Grid", "/Background"]


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def channel(clock):
    return Channel(clock)


def write(channel, kind, path, value):
    if kind == "delete":
        channel.delete(path)
    elif kind == "set_transform":
        channel.place(path, np.full((4, 4), float(value)))
    else:
        channel.set(path, "visible", value)


def test_a_burst_costs_one_message_and_the_newest_wins(channel, clock):
    page = Page(channel)
    write(channel, "set_transform", "/meshcat/a", 0)
    for value in range(1, 2000):
        write(channel, "set_transform", "/meshcat/a", value)
    assert len(page.messages) == 2, "the replay, and the first of the burst at once"
    clock.now += INTERVAL
    channel.flush()
    assert len(page.messages) == 3
    assert umsgpack.unpackb(page.state["set_transform", "/meshcat/a", ""])["matrix"][0] == 1999


def test_at_most_sixty_messages_a_second(channel, clock):
    page = Page(channel)
    for value in range(5000):
        clock.now += 0.001
        write(channel, "set_transform", "/meshcat/a", value)
    assert len(page.messages) <= 5 * 60 + 2
    channel.flush()
    assert umsgpack.unpackb(page.state["set_transform", "/meshcat/a", ""])["matrix"][0] == 4999


def test_a_batch_is_one_message_even_where_batches_nest(channel):
    page = Page(channel)
    with channel.batch():
        for path in PATHS:
            with channel.batch():
                write(channel, "set_transform", path, 1)
        assert len(page.messages) == 1
    assert [len(message["keys"]) for message in page.messages] == [0, len(PATHS)]


def test_an_exception_in_a_batch_loses_nothing(channel, clock):
    page = Page(channel)

    def interrupted():
        with channel.batch():
            write(channel, "set_transform", "/meshcat/a", 7)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    clock.now += 1
    write(channel, "set_transform", "/meshcat/c", 8)
    assert {path for _, path, _ in page.state} == {"/meshcat/a", "/meshcat/c"}


writes = st.lists(
    st.tuples(
        st.sampled_from(["set_transform", "set_property", "delete", "flush"]), st.sampled_from(PATHS), st.booleans()
    ),
    max_size=40,
)


@given(writes)
@settings(max_examples=200, deadline=None)
def test_replay_equals_the_live_state(steps):
    """A page that was there from the start and one that comes at the end hold the same scene, in the same order."""
    clock = Clock()
    channel = Channel(clock)
    early = Page(channel)
    for kind, path, value in steps:
        clock.now += 0.004
        channel.flush() if kind == "flush" else write(channel, kind, path, value)
    channel.flush()
    late = Page(Channel())
    late.take(*channel.replay())
    assert late.state == early.state


def test_messages_are_numbered_without_gaps(channel, clock):
    page = Page(channel)
    for value in range(5):
        clock.now += 1
        write(channel, "set_transform", "/meshcat/a", value)
    assert [message["seq"] for message in page.messages] == [0, 1, 2, 3, 4, 5]
    assert channel.replay()[0]["seq"] == channel.seq == 5


def test_without_a_page_nothing_is_kept_but_the_log(channel):
    for value in range(100):
        write(channel, "set_transform", "/meshcat/a", value)
    channel.flush()
    assert channel.seq == 0
    assert len(channel.log) == 1


def test_the_last_pose_is_sent_after_a_callback():
    """In a slider's callback there is no cell to end: the event loop flushes."""

    async def callbacks(channel):
        page = Page(channel)
        for value in range(10):
            write(channel, "set_transform", "/meshcat/a", value)
        await asyncio.sleep(5 * INTERVAL)
        return page

    page = asyncio.run(callbacks(Channel()))
    assert umsgpack.unpackb(page.state["set_transform", "/meshcat/a", ""])["matrix"][0] == 9
    assert len(page.messages) == 3


def test_all_open_channels_are_flushed_after_a_cell(channel):
    page = Page(channel)
    write(channel, "set_transform", "/meshcat/a", 1)
    write(channel, "set_transform", "/meshcat/a", 2)
    assert umsgpack.unpackb(page.state["set_transform", "/meshcat/a", ""])["matrix"][0] == 1
    channels.flush_all()
    assert umsgpack.unpackb(page.state["set_transform", "/meshcat/a", ""])["matrix"][0] == 2


def test_threads_may_write(channel):
    page = Page(channel)
    workers = [
        threading.Thread(target=lambda k=k: [write(channel, "set_transform", f"/meshcat/{k}", v) for v in range(300)])
        for k in range(4)
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    channel.flush()
    values = {k[1]: umsgpack.unpackb(v)["matrix"][0] for k, v in page.state.items()}
    assert values == {f"/meshcat/{k}": 299.0 for k in range(4)}


# ---- the real Visualizer writes to it ------------------------------------------------------------------


def test_the_real_visualizer_draws_into_the_channel(channel):
    page = Page(channel)
    vis = Visualizer(window=channel)
    vis["box"].set_object(Box([1, 2, 3]), MeshPhongMaterial(color=0xFF0000))
    vis["box"].set_transform(np.eye(4))
    vis["box"].set_property("visible", np.bool_(True))
    channel.flush()
    assert {key[:2] for key in page.state} == {
        (kind, "/meshcat/box") for kind in ("set_object", "set_transform", "set_property")
    }
    vis["box"].delete()
    channel.flush()
    assert page.state == {}
    assert channel.log == {}


def test_numpy_scalars_become_plain_numbers(channel):
    vis = Visualizer(window=channel)
    vis["box"].set_object(Box(np.array([1.0, 2.0, 3.0])))
    vis["ball"].set_property("scale", np.array([1, 2, 3]))
    commands = decoded(channel)
    assert commands["set_object", "/meshcat/box", ""]["object"]["geometries"][0]["width"] == 1.0
    assert commands["set_property", "/meshcat/ball", "scale"]["value"] == [1, 2, 3]


def test_packed_transforms_are_what_the_visualizer_sends(channel):
    matrix = np.random.default_rng(1).normal(size=(4, 4))
    Visualizer(window=channel)["a"].set_transform(matrix)
    theirs = decoded(channel)["set_transform", "/meshcat/a", ""]
    matrix[:3, 3] *= 1e3  # ours are in mm
    channel.place("/meshcat/a", matrix)
    ours = decoded(channel)["set_transform", "/meshcat/a", ""]
    assert ours.keys() == theirs.keys()
    np.testing.assert_allclose(ours["matrix"], theirs["matrix"], rtol=1e-15)


def test_what_a_channel_cannot_do_it_says(channel):
    vis = Visualizer(window=channel)
    assert vis.url() is None
    for ask in (vis.open, vis.wait, vis.get_image):
        with pytest.raises((NotImplementedError, AttributeError)):
            ask()
