"""The axis's step against closed forms, itself in pieces, and differences."""

import hypothesis
import hypothesis.strategies as st
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.test_util import check_grads

from identification.axis.motion import AxisParameters, AxisState, axis_positions, axis_step

EPS = float(jnp.finfo(jnp.float64).eps)

mass = st.floats(0.1, 500.0)
viscous = st.floats(0.0, 500.0)
coulomb = st.floats(0.0, 100.0)
offset = st.floats(-20.0, 20.0)
force = st.floats(-300.0, 300.0)
velocity = st.floats(-1.0, 1.0)
duration = st.floats(1e-4, 0.2)


compiled_step = jax.jit(axis_step)


def step(parameters, *, velocity, force, duration):
    state = AxisState(position=0.0, velocity=velocity)
    state = compiled_step(
        parameters, state, force=jnp.array(force), duration=jnp.array(duration)
    )
    return float(state.position), float(state.velocity)


def test_without_coulomb_friction_velocity_approaches_its_limit_exponentially():
    M, F_v, f, v_0, t = 90.0, 200.0, 30.0, 0.4, 0.3
    q, v = step(AxisParameters(M, F_v, 0.0, 0.0), velocity=v_0, force=f, duration=t)
    limit, decay = f / F_v, np.exp(-F_v / M * t)
    assert v == pytest.approx(limit + (v_0 - limit) * decay, rel=16 * EPS)
    expected = limit * t + (v_0 - limit) * M / F_v * (1 - decay)
    assert q == pytest.approx(expected, rel=32 * EPS)


def test_without_any_friction_acceleration_is_constant():
    q, v = step(AxisParameters(2.0, 0.0, 0.0, 1.0), velocity=0.5, force=5.0, duration=0.1)
    assert v == pytest.approx(0.5 + 2.0 * 0.1, rel=8 * EPS)
    assert q == pytest.approx(0.5 * 0.1 + 0.5 * 2.0 * 0.1**2, rel=8 * EPS)


@hypothesis.given(mass, viscous, st.floats(1e-3, 100.0), offset, st.floats(-1.0, 1.0), duration)
def test_at_rest_inside_the_cone_nothing_moves(mass, viscous, coulomb, offset, share, duration):
    parameters = AxisParameters(mass, viscous, coulomb, offset)
    # Rounding of force - offset must not leave the cone.
    held = offset + share * coulomb * (1 - 1e-9)
    assert step(parameters, velocity=0.0, force=held, duration=duration) == (0.0, 0.0)


def test_coasting_stops_after_the_way_that_the_energy_gives_and_stays():
    M, F_c, v_0 = 3.0, 6.0, 0.2
    parameters = AxisParameters(M, 0.0, F_c, 0.0)
    q, v = step(parameters, velocity=v_0, force=0.0, duration=10.0)
    assert v == 0.0
    assert q == pytest.approx(M * v_0**2 / (2 * F_c), rel=16 * EPS)


def test_a_reversal_inside_a_step_slips_on_from_the_closed_form_instant():
    M, F_c, v_0, f, t = 3.0, 6.0, 0.2, -24.0, 0.5
    q, v = step(AxisParameters(M, 0.0, F_c, 0.0), velocity=v_0, force=f, duration=t)
    stop = v_0 * M / (F_c - f)
    back = (f + F_c) / M
    assert v == pytest.approx(back * (t - stop), rel=16 * EPS)
    assert q == pytest.approx(v_0 * stop / 2 + back * (t - stop) ** 2 / 2, rel=32 * EPS)


@hypothesis.given(mass, viscous, coulomb, offset, force, velocity, duration)
def test_a_step_is_its_own_thirds_one_after_another(
    mass, viscous, coulomb, offset, force, velocity, duration
):
    parameters = AxisParameters(mass, viscous, coulomb, offset)
    whole = step(parameters, velocity=velocity, force=force, duration=duration)
    position, speed = 0.0, velocity
    for _ in range(3):
        move, speed = step(parameters, velocity=speed, force=force, duration=duration / 3)
        position += move
    # A few roundings of each term; the terms cancel, so they are the scale. At a stop the
    # instant's rounding is carried on by the largest acceleration.
    fastest = abs(velocity) + duration * (abs(force) + 120.0 + viscous) / mass
    tolerance = 256 * EPS * fastest
    assert abs(whole[1] - speed) <= tolerance
    assert abs(whole[0] - position) <= tolerance * max(duration, EPS)


@hypothesis.given(mass, viscous, coulomb, offset, force, velocity, duration)
def test_the_mirrored_axis_moves_the_other_way(
    mass, viscous, coulomb, offset, force, velocity, duration
):
    one = step(
        AxisParameters(mass, viscous, coulomb, offset),
        velocity=velocity,
        force=force,
        duration=duration,
    )
    other = step(
        AxisParameters(mass, viscous, coulomb, -offset),
        velocity=-velocity,
        force=-force,
        duration=duration,
    )
    assert one == (-other[0], -other[1])


def record(samples=60, dt=0.02):
    """A force that starts, sticks, reverses inside steps and stops an axis."""
    time = dt * jnp.arange(samples, dtype=float)
    return 40.0 * jnp.sin(7.0 * time) + 12.0 * jnp.sin(17.0 * time + 1.0), jnp.full(samples, dt)


def test_the_record_of_the_gradient_test_sticks_and_reverses():
    force, steps = record()
    parameters = AxisParameters(8.0, 10.0, 15.0, 2.0)
    positions = axis_positions(parameters, force, steps=steps, start=jnp.array(0.1))
    moves = np.diff(np.asarray(positions))
    assert np.any(moves == 0)
    assert np.any(moves > 0)
    assert np.any(moves < 0)


@pytest.mark.slow
def test_gradients_of_the_positions_are_those_of_differences():
    force, steps = record()

    @jax.jit
    def positions(theta):
        parameters = AxisParameters(theta[0], theta[1], theta[2], theta[3])
        return axis_positions(parameters, force, steps=steps, start=jnp.array(0.1))

    # Between the kinks the motion is smooth: central differences of 1e-6 are good to 1e-8.
    check_grads(
        positions,
        (jnp.array([8.0, 10.0, 15.0, 2.0]),),
        order=1,
        modes=("fwd", "rev"),
        eps=1e-6,
        atol=1e-6,
        rtol=1e-6,
    )


@jax.jit
def end_gradients(theta, speed, force):
    """Gradients of what a step ends at by parameters, velocity and force."""

    def end(theta, speed, force):
        parameters = AxisParameters(theta[0], theta[1], theta[2], theta[3])
        state = AxisState(position=jnp.array(0.0), velocity=speed)
        state = axis_step(parameters, state, force=force, duration=jnp.array(0.1))
        return state.position + state.velocity

    return jax.grad(end, argnums=(0, 1, 2))(theta, speed, force)


@pytest.mark.parametrize("speed", [0.0, 0.3, -0.3])
@pytest.mark.parametrize("viscous", [0.0, 1e-12, 5.0])
@pytest.mark.parametrize("force", [0.0, 3.0, -3.0, 50.0])
def test_gradients_are_finite_at_standstill_and_without_friction(speed, viscous, force):
    theta = jnp.array([2.0, viscous, 3.0, 0.0])
    gradients = end_gradients(theta, jnp.array(speed), jnp.array(force))
    assert all(bool(jnp.all(jnp.isfinite(gradient))) for gradient in gradients)
