"""Maps and samples: shares and counts agree with the scalar inverse, and do not depend on who computes them."""

import math
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial

import numpy as np
import psutil
import pytest

import omx
from omx.analysis import workspace

SAMPLES = 300_000  # several blocks, the last one cut short
STANFORD = omx.Chain(
    [(0, 1, 0, -math.pi / 2), (0, 1, 0, math.pi / 2), omx.DHRow(0, 0, 0, 0, prismatic=True),
     (0, 0, 0, -math.pi / 2), (0, 0, 0, math.pi / 2), (0, 1, 0, 0)],
    limits=[(-math.pi, math.pi), (-1.5, 1.5), (1, 3), (-math.pi, math.pi), (-0.4, 0.4), (-math.pi, math.pi)],
    name="Stanford arm",
)  # fmt: skip


class Here:
    """The least executor: one thing after another."""

    map = staticmethod(map)


# ---- maps ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def pitch_map():
    return workspace.pitch_map(step=20.0, pitches=60)


def test_shares_agree_with_the_scalar_inverse(pitch_map):
    rows, columns = np.nonzero(pitch_map.share > 0)
    for i in range(0, len(rows), 40):
        r, z = float(pitch_map.r[columns[i]]), float(pitch_map.z[rows[i]])
        legal = []
        for k in range(60):
            solutions = omx.ik([r, 0.0, z, (k + 0.5) * math.tau / 60 - math.pi])
            legal.append(sum(s.legal and abs(s.q[0]) < 1 for s in solutions))
        assert pitch_map.share[rows[i], columns[i]] == pytest.approx(np.mean(np.array(legal) > 0))
        assert pitch_map.branches[rows[i], columns[i]] == max(legal)


def test_no_point_is_dexterous(pitch_map):
    """18 % of the pitches on average and 38 % at best: every pitch is legal nowhere."""
    assert np.nanmean(pitch_map.share) == pytest.approx(0.18, abs=0.01)
    assert np.nanmax(pitch_map.share) == pytest.approx(0.38, abs=0.02)


def test_a_map_that_takes_a_minute_says_so():
    def stop(_):
        raise KeyboardInterrupt

    with pytest.warns(UserWarning, match="146 million poses"), pytest.raises(KeyboardInterrupt):
        workspace.pitch_map(step=0.5, allowed=stop)


def test_the_map_is_blank_outside_only(pitch_map):
    points = np.stack(np.meshgrid(pitch_map.r, pitch_map.z), axis=-1)
    assert (np.isfinite(pitch_map.share) == workspace.reaches(points)).all()


def test_a_rule_takes_away_and_never_adds(pitch_map):
    ruled = workspace.pitch_map(step=20.0, pitches=60, allowed=workspace.clear)
    inside = np.isfinite(pitch_map.share)
    assert (ruled.share <= pitch_map.share)[inside].all()
    assert (ruled.share < pitch_map.share)[inside].any()


def test_nothing_below_the_table_is_left():
    ruled = workspace.pitch_map(step=20.0, pitches=60, allowed=partial(workspace.clear, table=100.0))
    assert np.nanmax(ruled.share[ruled.z < 100.0]) == 0.0
    assert np.nanmax(ruled.share) > 0.1


def test_branch_counts_agree_with_the_scalar_inverse():
    found = workspace.branch_map(1.57, step=25.0)
    for i, z in enumerate(found.z.tolist()):
        for j, r in enumerate(found.r.tolist()):
            assert found.count[i, j] == sum(s.legal for s in omx.ik([r, 0.0, z, 1.57]))
    assert {0, 1, 2} <= set(found.count.ravel().tolist())


def test_no_pitches_are_refused():
    with pytest.raises(omx.BadInput, match="pitches"):
        workspace.pitch_map(pitches=0)


# ---- samples ---------------------------------------------------------------------------------------------


def test_samples_keep_the_limits_and_repeat():
    q = workspace.sample_joints(5000, seed=4)
    low, high = np.array(omx.LIMITS).T
    assert ((q >= low) & (q <= high)).all()
    assert (q == workspace.sample_joints(5000, seed=4)).all()
    assert (q != workspace.sample_joints(5000, seed=5)).any()


def test_counts_are_those_of_the_tips():
    counts = workspace.count_plane(SAMPLES, seed=2, step=10.0)
    q = workspace.sample_joints(SAMPLES, seed=2)
    q[:, 0] = 0.0
    edges = [np.append(axis - 5.0, axis[-1] + 5.0) for axis in counts.axes]
    expected = np.histogram2d(*omx.pose(q)[:, [0, 2]].T, bins=edges)[0]
    assert counts.counts.sum() == SAMPLES
    assert np.abs(counts.counts - expected).sum() <= 2  # a tip on the very edge of a cell


def test_counts_do_not_depend_on_the_workers():
    here = workspace.count_plane(2_200_000, seed=3, executor=Here()).counts
    assert (workspace.count_plane(2_200_000, seed=3).counts == here).all()
    with ThreadPoolExecutor(3) as threads:
        assert (workspace.count_plane(2_200_000, seed=3, executor=threads).counts == here).all()
    with ProcessPoolExecutor(2) as processes:
        assert (workspace.count_plane(2_200_000, seed=3, executor=processes).counts == here).all()


def test_counts_do_not_depend_on_a_cluster_that_listens_on_the_loopback_address():
    distributed = pytest.importorskip("dask.distributed", reason="dask is not installed")
    mine = psutil.Process()
    here = workspace.count_plane(SAMPLES, seed=3, executor=Here()).counts
    cluster = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None, "host": "127.0.0.1"}
    with distributed.Client(**cluster) as client:
        there = workspace.count_plane(SAMPLES, seed=3, executor=client.get_executor()).counts
        listening = {process: addresses(process) for process in [mine, *mine.children(recursive=True)]}
    assert (there == here).all()
    workers = [process for process, found in listening.items() if found and process != mine]
    assert len(workers) == 2
    assert listening[mine]  # the scheduler
    assert set().union(*listening.values()) == {"127.0.0.1"}
    assert psutil.wait_procs(workers, timeout=15)[1] == []
    assert not addresses(mine)


def addresses(process):
    """The addresses on which a process listens for TCP."""
    return {c.laddr.ip for c in process.net_connections("tcp") if c.status == psutil.CONN_LISTEN}


def test_progress_counts_samples():
    shares = []
    workspace.count_plane(2_200_000, progress=shares.append)
    assert shares == [1_048_576 / 2_200_000, 2_097_152 / 2_200_000, 1.0]


def test_space_and_plane_count_the_same_tips():
    space = workspace.count_space(50_000, seed=6, step=10.0)
    plane = workspace.count_plane(50_000, seed=6, step=10.0)
    assert (space.counts.sum(axis=(0, 1)) == plane.counts.sum(axis=0)).all()  # by height
    assert space.hit.shape[1] == 3
    assert space.size == len(space.hit) * 1000.0


@pytest.mark.parametrize("chain", [omx.COURSE.chain, STANFORD], ids=lambda chain: chain.name)
def test_any_chain_can_be_sampled(chain):
    step = 10.0 if chain.name != "Stanford arm" else 0.1
    counts = workspace.count_plane(20_000, seed=1, geometry=chain, step=step)
    q = workspace.sample_joints(20_000, seed=1, geometry=chain)
    r = np.hypot(*chain.fk(q)[:, :2, 3].T)
    assert counts.counts.sum() == 20_000
    assert counts.hit[:, 0].max() == pytest.approx(r.max(), abs=step)
    assert counts.axes[0][0] == pytest.approx(step / 2)


def test_a_chain_without_limits_is_refused():
    with pytest.raises(omx.BadInput, match="limits"):
        workspace.count_plane(100, geometry=omx.Chain([(0, 1, 0, 0)]))


@pytest.mark.parametrize("samples", [0, -5, 2.5, "many"])
def test_a_bad_number_of_samples_is_refused(samples):
    with pytest.raises(omx.BadInput, match="samples"):
        workspace.count_plane(samples)


def test_a_cell_without_size_is_refused():
    with pytest.raises(omx.BadInput, match="more than 0"):
        workspace.count_plane(100, step=0.0)
