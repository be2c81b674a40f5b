import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.engines.stepping import Inputs, simulate
from scdpr_jax.engines.tensioned_loop import (
    Tensioner,
    held_tension,
    logarithmic_creep,
    simulate_tensioned,
)
from scdpr_jax.robot.dynamics import masses
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import rest

EPS = float(np.finfo(float).eps)
ROBOT = consistent()
STIFFNESS, TENSION = 79e3, 85.0
INTERVALS = 500
run_tensioned = jax.jit(simulate_tensioned)


def loop(stiffness=STIFFNESS, gain=0.0, top_speed=1.0):
    return Tensioner(stiffness, TENSION, gain, top_speed)


def run(tensioner, robot=ROBOT, *, period=1e-3, volts=0.0, force=0.0, creep=0.0):
    count = round(INTERVALS * 1e-3 / period)
    inputs = Inputs(
        jnp.full(count, period),
        jnp.full((count, 2), volts),
        jnp.where(jnp.arange(count) < count // 10, force, 0.0),
    )
    here, height = jnp.asarray(1.0), jnp.asarray(0.4)
    start = rest(robot, here, here, height)
    crept = jnp.linspace(0.0, creep, count + 1)
    return run_tensioned(tensioner, robot, start, inputs, creep=crept), (start, inputs)


def test_loop_of_no_stiffness_is_the_constant_tension_model():
    found, (start, inputs) = run(loop(stiffness=0.0), volts=6.0, force=20.0)
    constant = jax.jit(simulate)(ROBOT, start, inputs)
    assert jnp.array_equal(found.states.position, constant.position)


def test_resting_loop_loses_its_stiffness_times_the_creep():
    found, _ = run(loop(), creep=0.5e-3)
    # A rounding of the metres that a length is made of, times the stiffness.
    assert abs(float(found.tension[-1]) - (TENSION - STIFFNESS * 0.5e-3)) <= 64 * EPS * 8 * 79e3


def test_slack_loop_pulls_with_nothing():
    found, _ = run(loop(), creep=5e-3)
    assert found.tension[-1] == 0


def energy_error(period):
    free = replace(
        ROBOT, {"friction_coefficient": 0.0, "drive_damping": 0.0, "effective_pretension": 1.0}
    )
    found, _ = run(loop(), free, period=period, force=30.0)
    kinetic = jnp.sum(masses(free)[None] * jnp.square(found.states.velocity), axis=1) / 2
    energy = np.asarray(kinetic + jnp.square(found.tension) / (2 * STIFFNESS))
    after = energy[len(energy) // 10 + 1 :]
    return float(np.ptp(after) / after[0])


@pytest.mark.slow
def test_energy_of_the_elastic_loop_is_kept_to_second_order():
    coarse, fine = energy_error(1e-3), energy_error(0.5e-3)
    assert fine <= 2e-3
    assert coarse / fine >= 3.0


def test_actuator_holds_against_even_creep_with_a_known_lag():
    tensioner = loop(gain=1 / (STIFFNESS * 0.05))
    found, _ = run(tensioner, creep=0.2e-3)
    rate = 0.2e-3 / 0.5
    expected = TENSION - STIFFNESS * rate * 0.05 * (1 - np.exp(-0.5 / 0.05))
    # The midpoint rule at a fiftieth of the time constant.
    assert abs(float(found.tension[-1]) - expected) <= 1e-3 * (TENSION - expected)


@pytest.mark.parametrize("gain", [0.0, 1e-9])
def test_hours_of_creep_follow_the_closed_form(gain):
    times = jnp.linspace(0.0, 1e5, 50)
    rate = 1e-8
    found = np.asarray(held_tension(loop(gain=gain), times=times, creep=rate * times))
    decay = STIFFNESS * gain
    lost = rate / gain * -np.expm1(-decay * times) if gain else STIFFNESS * rate * times
    # A sum of fifty exponentials.
    assert np.allclose(found, TENSION - lost, rtol=1e3 * EPS)


def test_creep_grows_by_its_strain_each_decade():
    times = jnp.asarray([0.0, 9.0, 99.0, 999.0]) * 3600
    found = logarithmic_creep(
        times,
        strain_per_decade=jnp.asarray(1e-5),
        onset=jnp.asarray(3600.0),
        length=jnp.asarray(8.0),
    )
    assert np.allclose(found, 8e-5 * np.arange(4), rtol=16 * EPS)
