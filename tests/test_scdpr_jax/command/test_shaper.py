import equinox as eqx
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.command.shaper import (
    ShapedTrajectory,
    Shaper,
    convolve,
    residual_phasor,
    residual_vibration,
    shape_samples,
)
from scdpr_jax.command.trajectory import rest_to_rest, table_3

SHAPER = Shaper([0.0, 0.11, 0.27], [0.4, 0.35, 0.25])
OTHER = Shaper([0.0, 0.2], [0.6, 0.4])
BOTH = convolve(SHAPER, OTHER)
IDENTITY = Shaper([0.0], [1.0])
LEG = rest_to_rest([0.3, 0.5], [1.9, 0.6], duration=1.0)
FREQUENCY, DAMPING = jnp.asarray(3.1), jnp.asarray(0.04)
UNSHAPED = eqx.filter_jit(LEG.position)
SHAPED = eqx.filter_jit(ShapedTrajectory(LEG, SHAPER).position)
EPS = float(jnp.finfo(FREQUENCY.dtype).eps)


@jax.jit
def vibration(shaper, frequency, damping_ratio):
    return residual_vibration(shaper, frequency=frequency, damping_ratio=damping_ratio)


@hypothesis.given(time=st.floats(-1, 3))
def test_shaped_trajectory_is_the_weighted_sum_of_delayed_ones(time):
    time = jnp.asarray(time)
    delayed = [UNSHAPED(time - delay) for delay in (0.0, 0.11, 0.27)]
    expected = 0.4 * delayed[0] + 0.35 * delayed[1] + 0.25 * delayed[2]
    got = SHAPED(time)
    assert jnp.max(jnp.abs(got - expected)) <= 16 * EPS


def test_shaped_trajectory_arrives_a_shaper_later():
    shaped = ShapedTrajectory(LEG, SHAPER)
    end = jnp.array([1.9, 0.6])
    assert jnp.abs(shaped.duration - 1.27) <= 4 * EPS
    assert jnp.max(jnp.abs(shaped.position(shaped.duration) - end)) <= 16 * EPS
    # 10 ms before, the last quarter still has 3 (0.01)² of 1.6 m to go: 0.12 mm.
    short = end - shaped.position(shaped.duration - 0.01)
    assert 0.1e-3 < short[0] < 0.13e-3


@eqx.filter_jit
def positions(trajectory, times):
    return jax.vmap(trajectory.position)(times)


def test_identity_shaper_changes_nothing():
    times = jnp.linspace(-0.5, 1.5, 23)
    shaped = positions(ShapedTrajectory(LEG, IDENTITY), times)
    assert jnp.max(jnp.abs(shaped - positions(LEG, times))) <= 4 * EPS


def test_shaped_samples_agree_with_the_shaped_trajectory():
    period = 1e-3
    times = period * jnp.arange(1500.0)
    shaped = jax.jit(shape_samples)(SHAPER, positions(LEG, times), period=jnp.asarray(period))
    exact = positions(ShapedTrajectory(LEG, SHAPER), times)
    # Chords of a curve of 9.6 m/s²: h²/8 times that, beside roundings.
    assert jnp.max(jnp.abs(shaped - exact)) <= period**2 / 8 * 9.6 + 1e-12


@jax.jit
def shaped_line(line, delay):
    shaper = Shaper(jnp.stack([0 * delay, delay]), [0.5, 0.5])
    return shape_samples(shaper, line, period=jnp.asarray(1.0))


@hypothesis.given(slope=st.floats(-5, 5), delay=st.floats(0, 3))
def test_shaped_samples_of_a_line_are_exact_between_the_samples(slope, delay):
    line = slope * jnp.arange(20.0)
    shaped = shaped_line(line, jnp.asarray(delay))
    expected = line[4:] - 0.5 * slope * delay
    assert jnp.max(jnp.abs(shaped[4:] - expected)) <= 16 * EPS * 100


@hypothesis.given(frequency=st.floats(0.5, 20), damping=st.floats(0, 0.5))
def test_one_impulse_leaves_all_of_the_vibration(frequency, damping):
    left = vibration(IDENTITY, jnp.asarray(frequency), jnp.asarray(damping))
    assert jnp.abs(left - 1) <= 4 * EPS


def test_residual_vibration_is_that_of_the_oscillator_itself():
    omega, damping = 2 * np.pi * float(FREQUENCY), float(DAMPING)
    oscillator = np.array([[0.0, 1.0], [-(omega**2), -2 * damping * omega]])
    state, before = np.zeros(2), 0.0
    for time, amplitude in zip([0.0, 0.11, 0.27], [0.4, 0.35, 0.25], strict=True):
        state = scipy.linalg.expm(oscillator * (time - before)) @ state + [0.0, amplitude]
        before = time
    position, speed = state
    damped = omega * np.sqrt(1 - damping**2)
    # Amplitude of the free vibration over that of a single unit impulse, 1 / omega_d.
    left = np.hypot(position, (speed + damping * omega * position) / damped) * damped
    # Exponentials of matrices of norm 60: two digits less than the type's.
    assert abs(left - float(vibration(SHAPER, FREQUENCY, DAMPING))) <= 1e3 * EPS


@hypothesis.given(frequency=st.floats(0.5, 20), damping=st.floats(0, 0.5))
def test_convolved_shapers_multiply_their_residual_vibration(frequency, damping):
    mode = (jnp.asarray(frequency), jnp.asarray(damping))
    product = vibration(SHAPER, *mode) * vibration(OTHER, *mode)
    # Phases of up to 2 pi 20 * 0.47 = 59 rad, each rounded.
    assert jnp.abs(vibration(BOTH, *mode) - product) <= 128 * EPS


def test_amplitudes_of_another_sum_are_refused_and_no_numbers_under_jit():
    with pytest.raises(ValueError, match="`amplitudes` of a shaper must sum to 1"):
        Shaper([0.0, 0.1], [0.5, 0.4])
    build = jax.jit(lambda amplitudes: Shaper([0.0, 0.1], amplitudes).amplitudes)
    assert jnp.all(jnp.isnan(build(jnp.array([0.5, 0.4]))))
    assert jnp.array_equal(build(jnp.array([0.5, 0.5])), jnp.array([0.5, 0.5]))


@pytest.mark.parametrize("times", [[0.1, 0.0], [-0.1, 0.1]])
def test_times_out_of_order_are_refused_and_no_numbers_under_jit(times):
    with pytest.raises(ValueError, match="`times` of a shaper must not be negative"):
        Shaper(times, [0.5, 0.5])
    build = jax.jit(lambda times: Shaper(times, [0.5, 0.5]).times)
    assert jnp.all(jnp.isnan(build(jnp.array(times))))
    assert jnp.array_equal(build(jnp.array([0.0, 0.1])), jnp.array([0.0, 0.1]))


def test_a_shaper_of_unlike_lengths_is_refused():
    with pytest.raises((ValueError, TypeError), match=r"impulses|lists of one length"):
        Shaper([0.0, 0.1, 0.2], [0.5, 0.5])


def test_residual_vibration_is_differentiable_in_mode_times_and_amplitudes():
    def left(frequency, damping_ratio, times, amplitude):
        shaper = Shaper(times, jnp.stack([amplitude, 1 - amplitude]))
        return vibration(shaper, frequency, damping_ratio)

    arguments = (FREQUENCY, DAMPING, jnp.array([0.02, 0.13]), jnp.asarray(0.55))
    check_grads(jax.jit(left), arguments, order=1, modes=("fwd", "rev"))


def test_residual_phasor_is_differentiable():
    def parts(frequency, damping_ratio):
        return residual_phasor(SHAPER, frequency=frequency, damping_ratio=damping_ratio)

    check_grads(jax.jit(parts), (FREQUENCY, DAMPING), order=1, modes=("fwd", "rev"))


def test_residual_vibration_has_zero_derivative_where_it_vanishes_exactly():
    # Only amplitudes of zero vanish without a rounding left.
    silent = eqx.tree_at(lambda shaper: shaper.amplitudes, SHAPER, jnp.zeros(3))
    for derivative in (jax.jacfwd, jax.jacrev):
        slopes = jax.jit(derivative(vibration, argnums=(0, 1, 2)))(silent, FREQUENCY, DAMPING)
        assert all(jnp.all(leaf == 0) for leaf in jax.tree.leaves(slopes))


def test_shaped_trajectory_is_differentiable_in_time_and_impulses():
    def at(time, times, amplitude):
        shaper = Shaper(times, jnp.stack([amplitude, 1 - amplitude]))
        return ShapedTrajectory(LEG, shaper).position(time)

    arguments = (jnp.asarray(0.6), jnp.array([0.01, 0.13]), jnp.asarray(0.55))
    check_grads(jax.jit(at), arguments, order=1, modes=("fwd", "rev"))


def test_shaped_samples_are_differentiable_in_samples_times_and_amplitudes():
    def shaped(samples, times, amplitude):
        shaper = Shaper(times, jnp.stack([amplitude, 1 - amplitude]))
        return shape_samples(shaper, samples, period=jnp.asarray(1.0))

    samples = jnp.sin(jnp.arange(8.0))[:, None]
    arguments = (samples, jnp.array([0.3, 2.6]), jnp.asarray(0.55))
    check_grads(jax.jit(shaped), arguments, order=1, modes=("fwd", "rev"))


def test_shapers_batch_over_impulses_and_modes():
    def left(delay, frequency):
        return vibration(
            Shaper(jnp.stack([0.0 * delay, delay]), [0.5, 0.5]), frequency, 0 * delay
        )

    frequencies = jnp.array([1.0, 2.0, 4.0])
    got = jax.jit(jax.vmap(left))(0.5 / frequencies, frequencies)
    # Two equal impulses half a period apart: cos and sin of pi, rounded.
    assert jnp.max(got) <= 4 * EPS


def test_shaped_manoeuvre_keeps_its_first_and_last_pose():
    shaped = ShapedTrajectory(table_3().vertical, SHAPER)
    ends = jnp.stack([shaped.position(jnp.asarray(-1.0)), shaped.position(shaped.duration)])
    assert jnp.max(jnp.abs(ends - jnp.array([[0.55, 0.20]]))) <= 16 * EPS
