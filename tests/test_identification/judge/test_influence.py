"""One Gauss-Newton step of a linear problem is its fit: closed forms all through."""

import numpy as np
import pytest

from experiments.virtual_rig import recovery
from identification.checks.leave_out import without_each_run
from identification.fit.run_sums import RunSums
from identification.judge.influence import (
    FEWEST,
    RunNormal,
    _eliminated,
    influence,
    moves,
    telling_runs,
)
from identification.judge.uncertainty import ParameterEstimate
from identification.result.estimation import estimate
from scdpr_jax.numerics.merit import Normal

NAMES = ("friction_coefficient", "drive_friction", "lower_carriage_damping")
FREE = np.full(3, -np.inf)


def sums(jacobian, residual):
    """A run of one channel with these residuals and derivatives."""
    size = jacobian.shape[1]
    return RunSums(
        cost=np.array([residual @ residual]),
        weight=np.ones(1),
        information=(jacobian.T @ jacobian)[None],
        gradient=jacobian.T @ residual,
        scores=np.zeros((40, size)),
        prior_cost=np.zeros(()),
        prior_information=np.zeros((size, size)),
        residuals=np.zeros((1, 2)),
    )


def linear(seed=0, runs=6, samples=30):
    """Runs with three shared quantities, one circumstance each, and their common fit."""
    random = np.random.default_rng(seed)
    jacobians = random.normal(size=(runs, samples, 8))
    # Only the sixth of eight columns is open: the third circumstance of five.
    jacobians[:, :, [3, 4, 6, 7]] = 0.0
    targets = random.normal(size=(runs, samples))
    return jacobians, targets, fitted(jacobians, targets, np.ones(runs))


def fitted(jacobians, targets, weights):
    """Quantities, and circumstances, of the least squares fit with each run weighted."""
    runs, samples, _ = jacobians.shape
    whole = np.zeros((runs, samples, 3 + runs))
    whole[:, :, :3] = jacobians[:, :, :3]
    whole[np.arange(runs), :, 3 + np.arange(runs)] = jacobians[:, :, 5]
    root = np.sqrt(weights)[:, None]
    rows = (whole * root[..., None]).reshape(-1, 3 + runs)
    found = np.linalg.lstsq(rows, (targets * root).ravel(), rcond=None)[0]
    return found[:3], found[3:]


def normal_of(jacobians, targets, found):
    shared, own = found
    active = np.array([False, False, True, False, False])
    parts = []
    for jacobian, target, number in zip(jacobians, targets, own, strict=True):
        residual = jacobian[:, :3] @ shared + jacobian[:, 5] * number - target
        parts.append(_eliminated(sums(jacobian, residual), 3, active))
    information, pull = zip(*parts, strict=True)
    names = tuple(f"run {k}" for k in range(len(parts)))
    return RunNormal(names, np.array(information), np.array(pull), nothing(3))


def nothing(size):
    return Normal(0.0, np.zeros(size), np.zeros((size, size)))


@pytest.mark.parametrize(
    "weights", [[0, 1, 1, 1, 1, 1], [2, 0, 1, 3, 0, 0], [1, 1, 1, 1, 1, 1]]
)
def test_weighted_runs_of_a_linear_problem_move_it_where_their_fit_is(weights):
    jacobians, targets, found = linear()
    weights = np.array(weights, dtype=float)
    (step,) = moves(normal_of(jacobians, targets, found), weights[None], lower=FREE)
    wanted, _ = fitted(jacobians, targets, weights)
    np.testing.assert_allclose(found[0] + step, wanted, rtol=1e-9)


def simple(information, pull):
    """Runs that tell a single quantity."""
    return RunNormal(
        tuple(f"run {k}" for k in range(len(pull))),
        np.asarray(information, dtype=float)[:, None, None],
        np.asarray(pull, dtype=float)[:, None],
        nothing(1),
    )


def test_a_step_ends_at_its_bound_and_the_others_follow():
    information = np.array([[2.0, 0.9, 0.0], [0.9, 1.0, 0.0], [0.0, 0.0, 1.0]])
    normal = RunNormal(("a",), information[None], np.array([[0.3, 1.0, -0.5]]), nothing(3))
    lower = np.array([-np.inf, -0.1, -np.inf])
    (step,) = moves(normal, np.ones((1, 1)), lower=lower)
    # The second stands at its bound, so the first minimises the rest by itself.
    np.testing.assert_allclose(step, [-(0.3 + 0.9 * -0.1) / 2.0, -0.1, 0.5], rtol=1e-9)


def test_what_only_the_run_left_out_tells_is_not_a_number():
    normal = RunNormal(
        ("a", "b"),
        np.array([np.diag([1.0, 4.0]), np.diag([1.0, 0.0])]),
        np.zeros((2, 2)),
        nothing(2),
    )
    step = moves(normal, 1.0 - np.eye(2), lower=np.full(2, -np.inf))
    np.testing.assert_array_equal(np.isnan(step), [[False, True], [False, False]])


def test_two_quantities_that_only_the_run_left_out_told_apart_are_not_numbers():
    together = np.array([[1.0, 1.0], [1.0, 1.0]])
    normal = RunNormal(
        ("a", "b"),
        np.array([together + np.diag([0.0, 1.0]), together]),
        np.zeros((2, 2)),
        nothing(2),
    )
    step = moves(normal, 1.0 - np.eye(2), lower=np.full(2, -np.inf))
    np.testing.assert_array_equal(np.isnan(step), [[True, True], [False, False]])


def test_equal_runs_all_tell_and_a_sole_one_tells_alone():
    np.testing.assert_allclose(telling_runs(simple(np.ones(7), np.zeros(7))), [7.0])
    np.testing.assert_allclose(telling_runs(simple([0, 5, 0], np.zeros(3))), [1.0])


def parameter(name="drive_friction_difference", *, value=0.0, sigma=1.0):
    return ParameterEstimate(
        name=name,
        setting=None,
        value=value,
        unit="N m",
        sigma=sigma,
        interval95=(value - 2 * sigma, value + 2 * sigma),
        status="identified",
    )


def mean_of(readings, information, resamples=4000):
    """What runs that each read a quantity with its own precision say of it."""
    mean = float(information @ readings / information.sum())
    normal = simple(information, information * (mean - readings))
    found = influence(
        normal, [parameter(value=mean)], encoded=np.array([mean]), resamples=resamples
    )
    return mean, found


def test_noise_alone_moves_as_far_as_is_said():
    random, information = np.random.default_rng(4), np.array([1.0, 4.0, 0.5, 2.0, 1.0, 1.0])
    drawn = [
        mean_of(random.normal(size=6) / np.sqrt(information), information, 10)[1]
        for _ in range(200)
    ]
    moved = np.array([one.moved[:, 0] for one in drawn])
    # The rms of 200 normal numbers scatters by 5 %: four of those.
    rms = np.sqrt(np.mean(np.square(moved), axis=0))
    np.testing.assert_allclose(rms, drawn[0].by_noise[:, 0], rtol=0.2)


def test_bootstrap_intervals_of_unequal_runs_hold_the_truth_in_90_to_99_percent():
    random, held = np.random.default_rng(5), 0
    for _ in range(200):
        information = np.exp(random.normal(size=14))
        # Runs differ by three times as much as their noise: only the bootstrap knows.
        readings = 3 * random.normal(size=14) / np.sqrt(information)
        (interval,) = mean_of(readings, information, 2000)[1].interval95
        held += interval is None or interval[0] <= 0 <= interval[1]
    assert 0.90 <= held / 200 <= 0.99


def test_a_run_that_says_something_else_stands_out():
    readings = np.random.default_rng(6).normal(size=8)
    readings[5] += 10
    _, found = mean_of(readings, np.ones(8), 10)
    against_noise = np.abs(found.moved / found.by_noise)[:, 0]
    assert np.argmax(against_noise) == 5
    assert against_noise[5] > 5


def test_too_few_runs_have_no_bootstrap():
    few = int(FEWEST) - 1
    _, found = mean_of(np.arange(float(few)), np.ones(few))
    assert found.interval95 == (None,)


def test_the_bootstrap_repeats_itself_with_its_seed():
    readings = np.arange(9.0)
    first, second = (mean_of(readings, np.ones(9))[1] for _ in range(2))
    assert first.interval95 == second.interval95


def test_what_has_no_standard_error_is_not_measured_by_it():
    normal = simple(np.ones(6), np.zeros(6))
    found = influence(normal, [parameter(sigma=np.inf)], encoded=np.zeros(1))
    assert np.all(np.isnan(found.moved))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 5, 11])
def test_a_step_without_a_run_goes_where_a_fit_without_it_ends(seed):
    logs = recovery.campaign(recovery.draw(seed), seed)
    found = estimate(logs)
    step, fits = found.influence, without_each_run(logs, found).influence
    assert fits.refitted
    # A fit ends within 0.1 standard errors, and a step is of first order.
    np.testing.assert_allclose(step.moved, fits.moved, rtol=0.05, atol=0.15)
