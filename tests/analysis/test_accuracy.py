"""Accuracy: first-order errors agree with sampling, and calibration finds what was hidden, with its uncertainty."""

import numpy as np
import pytest

import omx
from omx.analysis.accuracy import FITTED, TICK, TICK_SIGMA, calibrate, sensitivity, spread, tip_error, worst_tip_error
from omx.errors import BadInput, NotIdentifiable

RNG = np.random.default_rng(5)
LOW, HIGH = np.array(omx.LIMITS).T
HIDDEN = {"L2": 131.0, "L4": 125.0}
HIDDEN_OFFSETS = np.radians([0.5, -0.5, 0.5, -0.5])


def measured(count, noise, seed=1):
    """Joint readings and the tips of an arm that is not the one in the book: 1 mm and 0.5 deg off."""
    draw = np.random.default_rng(seed)
    q = draw.uniform(LOW, HIGH, (count, 4))
    tips = omx.pose(q + HIDDEN_OFFSETS, omx.COURSE.replace("hidden", **HIDDEN))[:, :3]
    return q, tips + draw.normal(0, noise, tips.shape)


def test_the_sensitivity_is_the_derivative_of_the_pose():
    q, h = RNG.uniform(LOW, HIGH, 4), 1e-6
    for name, move in sensitivity(q).items():
        if name.startswith("o"):
            step = h * np.eye(4)[int(name[1]) - 1]
            more, less = omx.pose(q + step), omx.pose(q - step)
        else:
            value = getattr(omx.COURSE, name)
            more, less = (omx.pose(q, omx.COURSE.replace(**{name: value + d})) for d in (h, -h))
        np.testing.assert_allclose(move, (np.array(more) - less)[:3] / (2 * h), atol=1e-6)


@pytest.mark.parametrize(
    "sigmas",
    [
        dict.fromkeys(("o1", "o2", "o3", "o4"), TICK_SIGMA),
        {"L2": 0.1, "L3": 0.1},
        {"delta": 1e-3, "o3": 1e-3, "L1": 0.2},
    ],
    ids=["ticks", "lengths", "mixed"],
)
def test_first_order_and_monte_carlo_agree(sigmas):
    for q in (omx.ZERO, omx.HOME, (0.4, 0.5, -0.9, 1.1)):
        tips = spread(q, sigmas, samples=4000)
        sampled = np.sqrt(((tips - omx.pose(q)[:3]) ** 2).sum(1).mean())
        assert sampled == pytest.approx(tip_error(q, sigmas), rel=0.05)


def test_no_error_is_larger_than_the_worst():
    bounds = dict.fromkeys(("o1", "o2", "o3", "o4"), TICK / 2)
    for q in RNG.uniform(LOW, HIGH, (20, 4)):
        off = RNG.uniform(-TICK / 2, TICK / 2, (500, 4))
        moved = np.linalg.norm(omx.pose(q + off)[:, :3] - omx.pose(q)[:3], axis=1)
        assert moved.max() <= worst_tip_error(q, bounds) * (1 + 1e-3)


def test_a_stretched_arm_turns_ticks_into_the_largest_errors():
    ticks = dict.fromkeys(("o1", "o2", "o3", "o4"), TICK_SIGMA)
    stretched = (0.0, np.pi / 2 - omx.COURSE.delta, omx.COURSE.delta - np.pi / 2, 0.0)
    errors = tip_error(RNG.uniform(LOW, HIGH, (2000, 4)), ticks)
    assert tip_error(stretched, ticks) > errors.max() * 0.99


@pytest.mark.parametrize("noise", [0.05, 0.2])
def test_calibration_recovers_hidden_lengths_and_offsets_within_its_own_uncertainty(noise):
    found = calibrate(*measured(60, noise))
    for name in FITTED:
        hidden = HIDDEN_OFFSETS[int(name[1]) - 1] if name[0] == "o" else HIDDEN.get(name, getattr(omx.COURSE, name))
        assert abs(found.value(name) - hidden) < 4 * found.sigma[name]
    assert found.noise == pytest.approx(noise, rel=0.25)
    assert found.before > 2.0
    assert found.after < 2 * noise


def test_without_noise_the_hidden_arm_is_found_exactly():
    found = calibrate(*measured(30, 0.0))
    np.testing.assert_allclose(found.offsets, HIDDEN_OFFSETS, atol=1e-9)
    assert pytest.approx(131.0, abs=1e-7) == found.geometry.L2
    assert found.after < 1e-7


def test_the_stated_uncertainty_is_the_scatter_of_repeated_calibrations():
    runs = [calibrate(*measured(40, 0.2, seed)) for seed in range(60)]
    for name in ("L2", "o3"):
        scatter = np.std([run.value(name) for run in runs])
        assert scatter == pytest.approx(np.mean([run.sigma[name] for run in runs]), rel=0.35)


def test_a_calibrated_arm_predicts_poses_that_it_was_not_fitted_to():
    found = calibrate(*measured(60, 0.05))
    q, tips = measured(200, 0.0, seed=9)
    errors = np.linalg.norm(found.pose(q)[:, :3] - tips, axis=1)
    before = np.linalg.norm(omx.pose(q)[:, :3] - tips, axis=1)
    assert errors.max() < 0.2
    assert before.mean() > 2.0


@pytest.mark.parametrize("q", [np.zeros((30, 4)), RNG.uniform(LOW, HIGH, (2, 4))], ids=["all alike", "too few"])
def test_configurations_that_say_too_little_are_refused(q):
    with pytest.raises(NotIdentifiable, match="Measure more"):
        calibrate(q, omx.pose(q)[:, :3])


def test_delta_cannot_be_told_from_the_offsets():
    q, tips = measured(60, 0.1)
    with pytest.raises(NotIdentifiable, match="delta"):
        calibrate(q, tips, names=(*FITTED, "delta"))


def test_mistakes_are_named():
    with pytest.raises(BadInput, match="L9"):
        tip_error(omx.ZERO, {"L9": 0.1})
    with pytest.raises(BadInput, match="0 or more"):
        tip_error(omx.ZERO, {"L1": -0.1})
    with pytest.raises(BadInput, match="points"):
        calibrate(np.zeros((5, 4)), np.zeros((4, 3)))
