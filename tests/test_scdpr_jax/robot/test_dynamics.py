"""The equations of motion against Lagrange's, and what their parts do."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.robot.cable import loop_forces, potential
from scdpr_jax.robot.dynamics import (
    accelerations,
    dampings,
    drive_forces,
    energy,
    gravity_force,
    knock_forces,
    masses,
    pulley_rates,
)
from scdpr_jax.robot.parameters import smoothed
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import State, carriages

EPS = np.finfo(float).eps
ROBOT = replace(
    eqx.tree_at(lambda r: r.gravity, consistent(), jnp.asarray(9.81)),
    {"loop_stiffness": 500.0, "drive_friction": 0.1, "drive_friction_difference": 0.02},
)
SMOOTH = smoothed(ROBOT, width=1e-4)
NONE = jnp.zeros(2)


def moving(seed):
    random = np.random.default_rng(seed)
    position = np.array([0.6, 0.0, 0.6, 0.6, 0.5]) + 0.05 * random.normal(size=5)
    return State(jnp.asarray(position), jnp.asarray(random.normal(size=5)))


moved = jax.jit(accelerations)


@pytest.mark.parametrize("seed", range(5))
def test_without_velocity_and_friction_the_force_is_the_potential_s_gradient(seed):
    state = moving(seed)
    still = State(state.position, jnp.zeros(5))
    found = moved(SMOOTH, still, torque=NONE, knock=jnp.asarray(0.0))
    force = -jax.grad(potential, argnums=1)(SMOOTH, state.position)
    # Some ten roundings of the loop's tension, 200 N, over masses of 1 kg and 0.025 kg m².
    assert jnp.abs(masses(SMOOTH) * found - force).max() <= 64 * EPS * 400


@pytest.mark.parametrize("seed", range(5))
def test_energy_changes_by_what_drives_knock_and_losses_do(seed):
    state, torque, knock = moving(seed), jnp.array([1.0, -0.5]), jnp.asarray(3.0)
    slope = moved(SMOOTH, state, torque=torque, knock=knock)
    change = jax.jvp(
        lambda q, v: energy(SMOOTH, State(q, v)),
        (state.position, state.velocity),
        (state.velocity, slope),
    )[1]
    work = state.velocity @ (drive_forces(SMOOTH, torque) + knock_forces(SMOOTH, knock))
    damped = dampings(SMOOTH) @ jnp.square(state.velocity)
    dry = work - damped - change
    # Once friction has turned round it takes all that the contacts hold.
    rates = jnp.abs(pulley_rates(SMOOTH, state.velocity))
    normal = loop_forces(SMOOTH, state.position).normal
    most = SMOOTH.lower_carriage.friction.coefficient * normal
    held = SMOOTH.drive.frictions @ rates + most @ jnp.abs(carriages(state.velocity))
    assert float(dry) == pytest.approx(float(held), rel=1e-2)


def test_drives_do_the_work_of_their_torques_on_their_pulleys():
    state, torque = moving(1), jnp.array([0.7, -0.2])
    power = torque @ pulley_rates(ROBOT, state.velocity)
    assert float(drive_forces(ROBOT, torque) @ state.velocity) == pytest.approx(
        float(power), rel=1e-14
    )


def test_weight_pulls_on_the_height_alone():
    force = gravity_force(ROBOT)
    assert float(force[4]) == pytest.approx(-2.1 * 9.81, rel=1e-15)
    assert jnp.all(force[:4] == 0)
    assert jnp.all(gravity_force(consistent()) == 0)
