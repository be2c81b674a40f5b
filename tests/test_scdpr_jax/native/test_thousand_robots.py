"""Machine code of drawn robots and events against XLA and the event-by-event reference."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from event_by_event import Nonlinear, simulate
from robot_numbers import numbers_of

import scdpr_jax
from scdpr_jax import native

SCALED = (
    *("effective_pretension", "drive_inertia", "drive_damping", "friction_coefficient"),
    *("end_effector_mass", "end_effector_inertia", "lower_carriage_mass"),
    *("upper_carriage_mass", "torque_per_volt", "effective_radius"),
)
"""What differs by up to 30 % from robot to robot."""
STEPS, INTERVAL = 60, 5e-3
AGREEMENT = 1e-11
"""Of states [m, rad, m/s, rad/s], and of each tangent's largest number."""
# XLA takes a minute and more to compile the derivatives; CI has those of `test_robots`.
COUNTS = [pytest.param(count, marks=pytest.mark.slow) for count in (24, 1000)]
GROUP = 200
"""Robots that XLA is given at a time, so that both counts have compiled the same."""


def robot_of(numbers):
    names = dict(zip((*SCALED, "drive_friction"), jnp.unstack(numbers), strict=True))
    return scdpr_jax.replace(scdpr_jax.consistent(), names)


def drawn(count):
    """Robots, where they begin, and what acts: half of them rest, half have drives that rub."""
    random = np.random.default_rng(20240)
    default = [float(scdpr_jax.value(scdpr_jax.consistent(), name)) for name in SCALED]
    numbers = default * random.uniform(0.7, 1.3, (count, len(SCALED)))
    rubs = random.uniform(0, 0.2, count) * random.integers(0, 2, count)
    start = np.zeros((count, 10))
    start[:, 0] = start[:, 2] = start[:, 3] = random.uniform(0.3, 0.7, count)
    start[:, 4] = random.uniform(0.2, 0.8, count)
    start[:, 3] += 1e-3 * random.normal(size=count)
    moves = random.integers(0, 2, (count, 1))
    start[:, 5:] = random.normal(size=(count, 5)) * [0.1, 0.3, 0.1, 0.1, 0.1] * moves
    held = random.uniform(-9, 9, (count, STEPS // 10, 2)).repeat(10, axis=1)
    knock = np.where(random.uniform(0, 1, (count, STEPS)) > 0.95, 20.0, 0.0)
    return np.column_stack([numbers, rubs]), start, held, knock


def step(robot, state, held):
    following = scdpr_jax.step(robot, state, held)
    return following, following


def trajectory(run, numbers, start, voltage, knock, duration):
    inputs = scdpr_jax.Inputs(duration, voltage, knock)
    first = scdpr_jax.State(start[:5], start[5:])
    states = run(step, robot_of(numbers), first, inputs)[1]
    return jnp.concatenate([states.position, states.velocity], axis=1)


@functools.partial(jax.jit, static_argnames="run")
@functools.partial(jax.vmap, in_axes=(None, 0, 0, 0, 0))
def whole(run, numbers, start, voltage, knock):
    duration = jnp.full(len(voltage), INTERVAL)
    return trajectory(run, numbers, start, voltage, knock, duration)


@functools.partial(jax.jit, static_argnames="run")
@functools.partial(jax.vmap, in_axes=(None, 0, 0, 0, 0))
def stepped(run, numbers, start, voltage, knock):
    """A step, and its derivatives by the robot, the start and what acts."""

    def moved(scale, start, voltage):
        duration = jnp.full(1, INTERVAL)
        end = trajectory(run, numbers * scale, start, voltage[None], knock[None], duration)[0]
        return end, end

    scale = jnp.ones_like(numbers)
    slopes, end = jax.jacfwd(moved, (0, 1, 2), has_aux=True)(scale, start, voltage)
    return end, jnp.concatenate(slopes, axis=1)


def in_groups(function, run, given):
    """A function of many robots, the last group filled up."""
    count = len(given[0])
    rows = np.minimum(np.arange(-(-count // GROUP) * GROUP), count - 1).reshape(-1, GROUP)
    parts = [function(run, *(own[row] for own in given)) for row in rows]
    joined = jax.tree.map(lambda *own: np.concatenate([*map(np.asarray, own)]), *parts)
    return jax.tree.map(lambda own: own[:count], joined)


@pytest.mark.parametrize("count", COUNTS)
def test_steps_and_all_their_derivatives_are_xlas(count):
    numbers, start, voltage, knock = drawn(count)
    states = in_groups(whole, native.run, (numbers, start, voltage, knock))
    # States that a run comes to have contacts that stick to the bit, slip and break away.
    before = np.concatenate([start[:, None], states[:, :-1]], axis=1)
    assert np.mean(before[:, :, 7:9] == 0) > 0.05
    place = np.random.default_rng(1).integers(0, STEPS, count)
    each = np.arange(count)
    given = numbers, before[each, place], voltage[each, place], knock[each, place]
    (found, slopes), (expected, others) = (
        in_groups(stepped, run, given) for run in (native.run, native.scan)
    )
    assert np.all(np.isfinite(slopes))
    np.testing.assert_array_equal(found[:, 7:9] == 0, expected[:, 7:9] == 0)
    assert np.abs(found - expected).max() <= AGREEMENT
    size = np.abs(others).max(axis=1, keepdims=True)
    assert np.max(np.abs(slopes - others) / np.maximum(size, 1e-3)) <= AGREEMENT


@pytest.mark.parametrize("count", [4, pytest.param(1000, marks=pytest.mark.slow)])
def test_fine_steps_are_the_event_by_event_references(count):
    numbers, start, voltage, knock = (own[:count] for own in drawn(max(count, 24)))
    short, parts = 4, 40

    @jax.jit
    @jax.vmap
    def fine(numbers, start, voltage, knock):
        duration = jnp.full(short * parts, INTERVAL / parts)
        held = jnp.repeat(voltage, parts, axis=0), jnp.repeat(knock, parts)
        return trajectory(native.run, numbers, start, *held, duration)[parts - 1 :: parts]

    voltage, knock = voltage[:, ::10][:, :short], knock[:, :short]
    found = np.asarray(fine(numbers, start, voltage, knock))
    for i in range(count):
        reference = simulate(
            Nonlinear(numbers_of(robot_of(jnp.asarray(numbers[i])))),
            start[i],
            np.full(short, INTERVAL),
            voltage[i],
            knock[i],
        )
        assert np.abs(found[i, :, :5] - reference.positions[1:]).max() <= AGREEMENT
