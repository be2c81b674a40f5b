"""Predictions over several horizons: restarts, derivatives, and what starts explain."""

import jax.numpy as jnp
import numpy as np
import pytest

from identification.axis.horizons import FIRST, LONGER, horizons
from identification.axis.log import AxisLog
from identification.axis.motion import AxisParameters, axis_positions
from identification.axis.record import axis_record

TRUTH = np.array([90.0, 190.0, 22.0, -3.0])
THETA = np.array([np.log(90.0), 190.0, 22.0, -3.0])


def record(*, sigma=0.0):
    time = 0.01 * np.arange(1000)
    voltage = 3.0 * np.sin(2.1 * time) + 1.5 * np.sin(6.7 * time + 1.0)
    positions = axis_positions(
        AxisParameters(*TRUTH),
        35.0 * jnp.asarray(voltage[:-1]),
        steps=jnp.full(len(time) - 1, 0.01),
        start=jnp.array(0.05),
    )
    noise = sigma * np.random.default_rng(2).normal(size=len(time))
    return axis_record(AxisLog(time, voltage, np.asarray(positions) + noise))


def seen(made, **options):
    return horizons(made, 35.0 * np.asarray(made.log.voltage), **options)


def exactly(ahead):
    return np.full(len(ahead.lengths), np.inf)


def test_a_record_has_as_many_horizons_as_it_is_long_enough_for():
    assert seen(record()).lengths == (0, FIRST)
    assert seen(record(), open_loop_alone=True).lengths == (0,)
    assert LONGER > 1


def test_the_true_law_leaves_the_open_loop_nothing_and_the_rest_little():
    made = record()
    ahead = seen(made)
    residuals, _ = ahead.linearised(THETA[None], exactly(ahead))
    assert np.max(np.abs(residuals[0, 0])) < 1e-12
    # Shorter predictions begin with velocities that a cubic through corners rounds off.
    assert np.sqrt(np.mean(residuals[0, 1] ** 2)) < 1e-3 * made.motion


def test_what_a_shifted_start_explains_is_taken_off():
    made = record()
    ahead = seen(made)
    starts = ahead.starts(THETA)
    columns = np.stack([starts, np.ones_like(starts)], axis=-1)
    # With errors of the model that are small, the starts are free.
    left = ahead.without_starts(columns, starts, np.full(len(ahead.lengths), 1e-40))
    np.testing.assert_allclose(left[0], columns[0])
    assert np.max(np.abs(left[1])) < 1e-6
    # With errors that are large beside the starts' noise, nothing is taken off.
    kept = ahead.without_starts(columns, starts, exactly(ahead))
    np.testing.assert_allclose(kept, columns)


@pytest.mark.parametrize("index", range(4))
def test_derivatives_are_those_of_differences(index):
    made = record()
    ahead = seen(made)
    theta = THETA * np.array([1.01, 1.1, 0.9, 1.1])
    step = 1e-6 * np.eye(4)[index] * max(abs(theta[index]), 1.0)
    square = exactly(ahead)
    both, _ = ahead.linearised(np.stack([theta + step, theta - step]), square)
    _, jacobian = ahead.linearised(theta[None], square)
    difference = (both[0] - both[1]) / (2 * np.sum(step))
    size = np.max(np.abs(jacobian[0, ..., index]))
    # An instant of stopping that a step moves over a sample's edge costs a few of them.
    error = np.abs(difference - jacobian[0, ..., index])
    assert np.quantile(error, 0.99) < 1e-4 * size
