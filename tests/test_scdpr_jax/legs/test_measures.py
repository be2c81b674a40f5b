import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.test_util import check_grads

from scdpr_jax.command.controller import published_pd
from scdpr_jax.engines.closed_loop import ClosedLoop
from scdpr_jax.legs.command_law import Commands
from scdpr_jax.legs.measures import (
    SETTLED,
    measure,
    peak_to_peak,
    smooth_peak_to_peak,
    tracking_error,
)
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.state import State, rest

TIME = jnp.linspace(0.0, 1.0, 2001)
WINDOW = (TIME >= 0.5).astype(TIME.dtype)


def test_a_sinusoid_swings_twice_its_amplitude_peak_to_peak():
    signal = 3e-3 * jnp.sin(2 * jnp.pi * 10 * TIME)
    # The grid of 0.5 ms may miss each peak by half a step: (2π·10·0.25 ms)²/2 of it.
    tolerance = 6e-3 * (2 * jnp.pi * 10 * 0.25e-3) ** 2 / 2
    assert abs(float(peak_to_peak(signal, WINDOW)) - 6e-3) <= tolerance


def test_the_smooth_surrogate_of_a_sinusoid_is_its_mean_of_eighth_order():
    signal = 1.0 + 3e-3 * jnp.sin(2 * jnp.pi * 10 * TIME)
    # The mean of sin^8 is 35/128; the window's end counts one sample of 1001 twice.
    expected = 6e-3 * (35 / 128) ** 0.125
    assert abs(float(smooth_peak_to_peak(signal, WINDOW)) / expected - 1) <= 2e-3


def test_what_happens_before_the_window_does_not_count():
    signal = jnp.where(TIME < 0.5, 1.0, 0.0)
    assert float(peak_to_peak(signal, WINDOW)) == 0
    assert float(smooth_peak_to_peak(signal, WINDOW)) == 0


def test_a_signal_at_rest_has_a_surrogate_with_a_finite_gradient():
    gradient = jax.grad(lambda s: smooth_peak_to_peak(s, WINDOW))(jnp.zeros_like(TIME))
    assert jnp.all(jnp.isfinite(gradient))


def test_the_surrogate_is_differentiable_in_both_modes():
    def swing(amplitude):
        return smooth_peak_to_peak(amplitude * jnp.sin(20 * TIME) + TIME, WINDOW)

    check_grads(jax.jit(swing), (0.3,), order=1, modes=("fwd", "rev"))


def test_the_error_of_eq_26_is_the_distance_to_the_reference():
    error = tracking_error(jnp.array([[0.0, 0.0]]), jnp.array([[3.0, 4.0]]))
    assert float(error[0]) == 5


def test_the_error_of_eq_26_has_a_finite_gradient_on_the_reference():
    place = jnp.zeros((1, 2))
    assert jnp.all(jax.grad(lambda p: jnp.sum(tracking_error(p, place)))(place) == 0)


ROBOT = consistent()
SAMPLES, ARRIVED = 400, 200
LINE = rest(ROBOT, *jnp.asarray([1.02, 1.01, 0.5]))
TARGET = jnp.asarray([1.0, 0.5])


def measured(*, swing=0.0, tilt=0.0, volts=1.0, reach=0.0):
    """Carriages at rest out of line; the end-effector swings about that line and tilts."""
    time = 1e-3 * jnp.arange(float(SAMPLES))
    position = jnp.tile(LINE.position, (SAMPLES, 1))
    late = jnp.arange(SAMPLES) >= ARRIVED
    position = position.at[:, 0].add(jnp.where(late, swing * jnp.cos(60 * time), 0.0))
    position = position.at[50, 1].set(tilt).at[:ARRIVED, 0].add(reach)
    voltage = jnp.zeros((SAMPLES - 1, 2)).at[10, 1].set(-volts)
    run = ClosedLoop(time, State(position, jnp.zeros_like(position)), voltage)
    commanded = jnp.tile(TARGET, (SAMPLES, 1))
    commands = Commands(published_pd(), commanded + 0.1, commanded, late)
    return measure(ROBOT, run, commands)


@pytest.mark.parametrize("swing", [0.0, 2e-3, 8e-3])
def test_the_resting_error_is_the_lines_however_the_end_effector_swings(swing):
    expected = float(LINE.position[0]) - 1.0
    assert float(measured(swing=swing).resting_error) == pytest.approx(expected, rel=1e-12)


def test_the_vibration_counts_once_the_reference_has_ended():
    # A whole period of 105 samples lies in the rest; its peaks are missed by half a sample.
    leg = measured(swing=2e-3, reach=0.3)
    assert float(leg.residual_vibration) == pytest.approx(4e-3, rel=1e-3)


def test_errors_count_against_their_own_references():
    leg = measured()
    distance = float(LINE.position[0]) - 1.0
    assert float(leg.largest_error) == pytest.approx(distance, rel=1e-12)
    assert float(leg.rms_error) == pytest.approx(distance, rel=1e-12)
    expected = np.hypot(distance - 0.1, 0.1)
    assert float(leg.largest_original_error) == pytest.approx(expected, rel=1e-12)


def test_the_largest_tilt_is_of_either_sign():
    assert float(measured(tilt=-0.07).largest_tilt) == pytest.approx(0.07)


def test_a_drive_saturates_at_its_limit_and_not_below():
    limit = float(ROBOT.drive.voltage_limit)
    assert float(measured(volts=limit).saturation) == pytest.approx(1 / (SAMPLES - 1))
    assert float(measured(volts=0.99 * limit).saturation) == 0
    assert float(measured(volts=limit).largest_voltage) == limit


def test_what_stays_away_never_settles():
    assert np.isnan(float(measured().settling_time))


def test_a_leg_settles_when_it_was_last_away():
    position = jnp.tile(jnp.asarray([1.0, 0.0, 1.0, 1.0, 0.5]), (SAMPLES, 1))
    for last in (-1, 0, 150):
        away = position.at[: last + 1, 0].add(1.01 * SETTLED)
        run = ClosedLoop(
            1e-3 * jnp.arange(float(SAMPLES)),
            State(away, jnp.zeros_like(away)),
            jnp.zeros((SAMPLES - 1, 2)),
        )
        commanded = jnp.tile(TARGET, (SAMPLES, 1))
        late = jnp.arange(SAMPLES) >= ARRIVED
        leg = measure(ROBOT, run, Commands(published_pd(), commanded, commanded, late))
        assert float(leg.settling_time) == pytest.approx(1e-3 * (last + 1))
