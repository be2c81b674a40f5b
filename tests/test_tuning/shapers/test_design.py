"""Optimised shapers: never worse than any other of their kind."""

import jax.numpy as jnp
import numpy as np
import pytest
from share import share

from scdpr_jax.command.shaper import Shaper
from tuning.shapers.catalogue import CATALOGUE, um_ei, zvd
from tuning.shapers.comparison import fitted
from tuning.shapers.design import (
    convolved,
    least_duration,
    least_quantile,
    least_residual,
    least_unity_residual,
    simultaneous,
    specified_insensitivity,
    worst_residual,
)
from tuning.shapers.design.minimax import Minimax, minimise
from tuning.shapers.design.positive import EXACT, GAP
from tuning.shapers.design.refine import refined
from tuning.shapers.measures import insensitivity, residual_of_modes, smoothing

MODES = 24


def spread(seed):
    """A random spread of modes; every one of as many, so that all share compiled code."""
    random = np.random.default_rng(seed)
    middle = np.exp(random.uniform(np.log(0.3), np.log(200.0)))
    width, ratio = random.uniform(0.01, 0.3), random.uniform(0, 0.12)
    frequency = middle * (1 + width * random.uniform(-1, 1, MODES))
    return worst_residual(frequency, ratio * random.uniform(0.5, 1.5, MODES)), ratio


def compared(seed):
    criterion, ratio = spread(seed)
    return criterion, fitted(CATALOGUE[seed % len(CATALOGUE)], criterion, damping_ratio=ratio)


def never_worse_nor_longer(seed):
    criterion, fit = compared(seed)
    same = least_residual(criterion, duration=float(fit.shaper.duration))
    assert same.residual <= fit.residual + GAP
    assert float(same.shaper.duration) <= float(fit.shaper.duration) * (1 + 1e-12)
    shorter = least_duration(criterion, bound=fit.residual, starts=[fit.shaper])
    assert shorter.residual <= fit.residual
    assert float(shorter.shaper.duration) <= float(fit.shaper.duration)
    return fit.residual / max(same.residual, 1e-12)


@pytest.mark.parametrize("seed", share(range(14), 3))
def test_optimised_is_never_worse_nor_longer_than_the_catalogue(seed):
    never_worse_nor_longer(seed)


@pytest.mark.slow
def test_optimised_beats_the_catalogue_on_a_thousand_spreads():
    gains = [never_worse_nor_longer(seed) for seed in range(1000)]
    assert np.median(gains) > 1.05


@pytest.mark.parametrize("share", [0.5, 0.8, 0.99])
def test_too_short_for_one_mode_leaves_what_two_equal_impulses_leave(share):
    # Undamped, within half a period the best are two halves at the ends: cos(pi f D).
    frequency, duration = 3.0, share * 0.5 / 3.0
    criterion = worst_residual(jnp.full(MODES, frequency), jnp.zeros(MODES))
    best = least_residual(criterion, duration=duration)
    assert abs(best.residual - np.cos(np.pi * frequency * duration)) <= 1e-7
    assert best.lower_bound <= best.residual + GAP


def test_half_a_period_is_the_shortest_that_leaves_nothing():
    criterion = worst_residual(jnp.full(MODES, 3.0), jnp.zeros(MODES))
    best = least_duration(criterion, bound=1e-4)
    # Two halves D apart leave cos(pi f D): 1e-4 is 3e-5 of the period short of it.
    assert abs(float(best.shaper.duration) - (0.5 - 1e-4 / np.pi) / 3.0) <= EXACT / 3.0


def test_a_bound_that_no_shaper_keeps_is_refused():
    criterion = worst_residual(jnp.linspace(0.01, 5.0, MODES), jnp.zeros(MODES))
    with pytest.raises(ValueError, match=r"No shaper of up to .* allow more"):
        least_duration(criterion, bound=1e-6)


def test_refining_never_makes_a_shaper_worse():
    criterion, _ = spread(3)
    random = np.random.default_rng(5)
    period = 1 / float(jnp.mean(criterion.frequency))
    for _ in range(8):
        times = np.sort(np.append(0.0, random.uniform(0, 1.2, 3))) * period
        amplitudes = random.dirichlet(np.ones(4))
        shaper = Shaper(times, amplitudes)
        assert criterion(refined(criterion, shaper)) <= criterion(shaper)


def test_interior_point_method_finds_a_minimum_in_closed_form():
    # |1 - x| and |x| with weights 2 and 1: equal at x = 2/3, where both are 2/3.
    problem = Minimax(
        offset=jnp.array([[1.0, 0.0], [0.0, 0.0]]),
        slope=jnp.array([[[-1.0], [1.0]], [[0.0], [0.0]]]),
        tolerated=jnp.zeros(2),
        weights=jnp.diag(jnp.array([2.0, 1.0])),
        lower=jnp.array([-1.0]),
        upper=jnp.array([3.0]),
        balance=jnp.zeros(1),
    )
    found = minimise(problem, jnp.array([0.2]), jnp.asarray(1e-9))
    assert bool(found.converged)
    assert abs(float(found.x[0]) - 2 / 3) <= 1e-8
    assert found.lower_bound <= 2 / 3 <= found.value + 1e-15
    assert found.value - found.lower_bound <= 1e-8


def test_interior_point_method_keeps_what_is_conserved_and_what_is_tolerated():
    # The sum stays 1; up to 0.4 of the first costs nothing, so it takes 0.4.
    problem = Minimax(
        offset=jnp.zeros((2, 2)),
        slope=jnp.stack([jnp.eye(2), jnp.zeros((2, 2))]),
        tolerated=jnp.array([0.4, 0.0]),
        weights=jnp.array([[1.0, 0.5]]),
        lower=jnp.zeros(2),
        upper=jnp.full(2, 2.0),
        balance=jnp.ones(2),
    )
    found = minimise(problem, jnp.array([0.5, 0.5]), jnp.asarray(1e-9))
    assert jnp.max(jnp.abs(found.x - jnp.array([0.4, 0.6]))) <= 1e-7
    assert abs(float(found.value) - 0.3) <= 1e-8


@pytest.mark.slow
def test_unity_magnitude_design_is_never_worse_than_the_catalogue():
    criterion = worst_residual(jnp.linspace(2.7, 3.3, MODES), jnp.full(MODES, 0.03))
    known = um_ei(3.0, 0.03)
    best = least_unity_residual(
        criterion, duration=float(known.duration), damping_ratio=0.03, starts=[known]
    )
    assert jnp.all(jnp.abs(best.amplitudes) == 1)
    assert criterion(best) < criterion(known)


@pytest.mark.parametrize("frequency", [2.4, 3.2, 3.9])
@pytest.mark.parametrize("ratio", [0.01, 0.1])
def test_one_percent_at_a_mode_and_five_around_it_take_less_than_zvd(frequency, ratio):
    around = np.append(np.linspace(0.9, 1.1, MODES - 1), 1.0)
    limits = np.append(np.full(MODES - 1, 0.05), 0.01)
    criterion = worst_residual(frequency * around, np.full(MODES, ratio), limits=limits)
    best = least_duration(criterion, bound=1.0).shaper
    fine = frequency * np.linspace(0.9, 1.1, 501)
    left = residual_of_modes(best, fine, np.full(501, ratio))
    assert left[250] <= 0.01
    # Between the design's frequencies the curve is that much above a chord at the most.
    assert left.max() <= 0.05 * 1.005
    assert float(best.duration) < float(zvd(frequency, ratio).duration)


@pytest.mark.slow
def test_specified_insensitivity_holds_over_its_band_in_less_than_ei():
    shaper = specified_insensitivity((2.7, 3.3), 0.05)
    fine = np.linspace(2.7, 3.3, 3001)
    assert residual_of_modes(shaper, fine, np.full(3001, 0.05)).max() <= 0.05 * 1.001
    assert float(shaper.duration) < 1 / 3.0
    width = insensitivity(shaper, frequency=3.0, damping_ratio=0.05, tolerance=0.0501)
    assert width >= 0.2


@pytest.mark.slow
def test_simultaneous_shaper_empties_two_modes_in_less_time_than_one_after_the_other():
    modes = ([2.4, 3.9], [0.02, 0.05])
    both = simultaneous(*modes)
    assert np.max(residual_of_modes(both, *map(np.asarray, modes))) <= 1e-12
    after = convolved(*modes)
    assert np.max(residual_of_modes(after, *map(np.asarray, modes))) <= 1e-12
    assert float(both.duration) < 0.99 * float(after.duration)


@pytest.mark.slow
def test_quantile_is_lower_than_the_worst_case():
    random = np.random.default_rng(2)
    frequency, ratio = random.normal(3.0, 0.2, MODES), np.full(MODES, 0.03)
    worst = least_residual(worst_residual(frequency, ratio), duration=0.25)
    most = least_quantile(frequency, ratio, share=0.8, duration=0.25)
    assert most.residual < worst.residual
    left = np.sort(residual_of_modes(most.shaper, frequency, ratio))
    assert left[int(np.ceil(0.8 * MODES)) - 1] == most.residual


def test_smoothing_is_the_distance_from_a_delayed_parabola():
    shaper, acceleration, time = Shaper([0.0, 0.1, 0.3], [0.5, 0.3, 0.2]), 5.0, 2.0
    shaped = np.asarray(shaper.amplitudes) @ (
        acceleration / 2 * (time - np.asarray(shaper.times)) ** 2
    )
    delay = float(shaper.amplitudes @ shaper.times)
    expected = shaped - acceleration / 2 * (time - delay) ** 2
    assert abs(float(smoothing(shaper, acceleration=acceleration)) - expected) <= 1e-14
