"""Runs of random robots as machine code against the same runs by XLA."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import scdpr_jax
from scdpr_jax import native
from scdpr_jax.numerics.lean_scan import lean_scan

STEPS, ROBOTS, INTERVAL = 400, 24, 5e-3
NAMES = ("effective_pretension", "drive_inertia", "drive_damping", "friction_coefficient")
AGREEMENT = 1e-12
"""Of the largest number; knocks and events make more of a rounding, which is measured."""


def step(robot, state, held):
    following = scdpr_jax.step(robot, state, held)
    return following, following


def scan(step, robot, start, inputs):
    return lean_scan(lambda carry, row: step(robot, carry, row), start, inputs)


def trajectory(run, parameters, start, voltage, knock):
    robot = scdpr_jax.replace(
        scdpr_jax.consistent(), dict(zip(NAMES, jnp.unstack(parameters), strict=True))
    )
    held = scdpr_jax.Inputs(duration=jnp.full(STEPS, INTERVAL), voltage=voltage, knock=knock)
    start = scdpr_jax.State(start[:5], start[5:])
    return run(step, robot, start, held)[1]


def random_runs():
    """Robots up to 30 % from the default one, pushed to and fro with rests and knocks."""
    random = np.random.default_rng(2)
    default = [float(scdpr_jax.value(scdpr_jax.consistent(), name)) for name in NAMES]
    parameters = default * (1 + 0.3 * random.uniform(-1, 1, (ROBOTS, len(NAMES))))
    time = INTERVAL * np.arange(STEPS)[:, None]
    frequency = random.uniform(0.3, 1.5, (ROBOTS, 1, 2))
    wave = np.sin(2 * np.pi * (frequency * time + random.uniform(0, 1, (ROBOTS, 1, 2))))
    acts = random.uniform(0, 1, (ROBOTS, STEPS // 50, 1)).repeat(50, axis=1) > 0.3
    voltage = random.uniform(2, 12, (ROBOTS, 1, 1)) * wave * acts
    knock = np.where(random.uniform(0, 1, (ROBOTS, STEPS)) > 0.99, 20.0, 0.0)
    start = np.tile([1.0, 0, 1, 1, 0.5, 0, 0, 0, 0, 0], (ROBOTS, 1))
    start[:, 5:] += 0.05 * random.normal(size=(ROBOTS, 5)) * random.integers(0, 2, (ROBOTS, 1))
    return parameters, start, voltage, knock


def assert_agree(found, expected, *, sensitive):
    """Both are equal as far as one rounding of the voltages leaves them the same."""
    leaves = map(jax.tree.leaves, (found, expected, sensitive))
    for own, other, third in zip(*leaves, strict=True):
        assert np.all(np.isfinite(own))
        rounding = 8 * np.max(np.abs(third - own))
        assert np.max(np.abs(own - other)) <= rounding + AGREEMENT * np.max(np.abs(other))


def rounded(runs):
    """The same runs with voltages off by one rounding."""
    parameters, start, voltage, knock = runs
    return parameters, start, np.nextafter(voltage, np.inf), knock


@pytest.mark.slow
def test_states_and_tangents_are_xlas():
    def both(run, runs):
        def along(parameters, start, voltage, knock):
            def moved(parameters, voltage):
                return trajectory(run, parameters, start, voltage, knock)

            seeds = 0.1 * parameters, 0.1 * voltage
            return jax.jvp(moved, (parameters, voltage), seeds)

        return jax.jit(jax.vmap(along))(*runs)

    runs = random_runs()
    sensitive = both(native.run, rounded(runs))
    assert_agree(both(native.run, runs), both(scan, runs), sensitive=sensitive)


def test_a_robot_alone_has_the_states_of_a_robot_among_many():
    def alone(runs):
        return trajectory(native.run, *(jnp.asarray(own[3]) for own in runs))

    runs = random_runs()
    many = jax.vmap(lambda *own: trajectory(native.run, *own))(*runs)
    expected = jax.tree.map(lambda own: own[3], many)
    assert_agree(alone(runs), expected, sensitive=alone(rounded(runs)))


def test_tangents_are_those_of_differences():
    parameters, start, voltage, knock = (jnp.asarray(own[0]) for own in random_runs())

    def last(size):
        changed = parameters.at[2].multiply(1 + size)
        states = trajectory(native.run, changed, start, voltage, knock)
        return jnp.concatenate([states.position[100], states.velocity[100]])

    slope, width = jax.jacfwd(last)(0.0), 1e-6
    difference = (last(width) - last(-width)) / (2 * width)
    # The rounding of states of size one over the width, and its square.
    np.testing.assert_allclose(slope, difference, atol=1e-8)
