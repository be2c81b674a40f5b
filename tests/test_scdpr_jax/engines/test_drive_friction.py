"""Exact dry friction of the drives: the fixed-grid engines held to the reference."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from event_by_event import Linear, Nonlinear, simulate
from robot_numbers import numbers_of

from scdpr_jax.engines import stepping
from scdpr_jax.engines.linear_stepping import simulate_linear
from scdpr_jax.robot.dynamics import energy
from scdpr_jax.robot.friction import Coulomb
from scdpr_jax.robot.parameters import with_friction
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import State, rest

GRID = 5e-3
"""Interval of the reference's inputs [s]."""
STEPS = 240
VARIED = (
    "friction_coefficient",
    "drive_inertia",
    "drive_damping",
    "effective_pretension",
)
NAMES = (*VARIED, "drive_friction", "drive_friction_difference")
START = np.array([0.404, 0.01, 0.40, 0.40, 0.45, 0.05, 0.1, 0.2, 0.3, 0.1])


def held(*parts):
    """Voltages: each part from one step to another."""
    voltage = np.zeros((STEPS, 2))
    for begin, end, both in parts:
        voltage[begin:end] = both
    return voltage


MOVES = {
    "horizontal": held((0, 100, [6.0, 5.5])),
    "diagonal": held((0, 70, [8.0, 3.0])),
    "downwards": held((0, 60, [-1.0, 7.0])),
    "vertical": held((0, 40, [5.0, -5.0]), (40, 70, [-2.0, 2.0])),
    "again": held((0, 60, [6.0, 4.0]), (110, 160, [-6.0, -5.0])),
    "reversed": held((0, 40, [8.0, 6.0]), (40, 80, [-8.0, -7.0]), (80, 110, [7.0, -7.0])),
}


def drawn(seed):
    """A robot near the prototype, its drives of different friction from 0.02 to 0.5 N m."""
    random = np.random.default_rng(seed)
    factors = random.uniform(0.7, 1.3, len(VARIED))
    numbers = {
        n: f * float(value(consistent(), n)) for n, f in zip(VARIED, factors, strict=True)
    }
    torque = np.exp(random.uniform(*np.log([0.02, 0.5])))
    difference = random.uniform(-0.6, 0.6) * torque
    numbers |= {"drive_friction": torque, "drive_friction_difference": difference}
    return replace(consistent(), numbers)


def inputs_of(voltage, parts):
    """Inputs of `parts` steps in each of the reference's intervals."""
    count = parts * STEPS
    return stepping.Inputs(
        jnp.full(count, GRID / parts), jnp.repeat(voltage, parts, axis=0), jnp.zeros(count)
    )


def linear(robot, start, inputs):
    return simulate_linear(
        robot,
        start,
        height=jnp.asarray(START[4]),
        interval=inputs.duration[0],
        voltage=inputs.voltage,
        knock=inputs.knock,
    )


ENGINES = {"nonlinear": jax.jit(stepping.simulate), "linear": jax.jit(linear)}
SYSTEMS = {"nonlinear": Nonlinear, "linear": lambda numbers: Linear(numbers, START[4])}
both_models = pytest.mark.parametrize("model", ENGINES)


def simulated(model, robot, inputs):
    return ENGINES[model](robot, State(START[:5], START[5:]), inputs)


def reference(model, robot, move):
    system = SYSTEMS[model](numbers_of(robot))
    return simulate(system, START, np.full(STEPS, GRID), MOVES[move], np.zeros(STEPS))


def error(model, robot, move, run, parts):
    """Largest error of a position [m]; the tilt moves the attachments by their arm."""
    states = simulated(model, robot, inputs_of(MOVES[move], parts))
    found = np.asarray(states.position)[::parts]
    arm = numbers_of(robot).lower_offset
    return np.abs((found - run.positions) * np.array([1.0, arm, 1.0, 1.0, 1.0])).max()


def some(count):
    """A seed that is always tested, and others in the slow suite."""
    return [0, *(pytest.param(s, marks=pytest.mark.slow) for s in range(1, count))]


@both_models
@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("seed", some(12))
def test_errors_are_within_bounds_at_200_hz_and_1_khz(seed, move, model):
    robot = drawn(seed)
    run = reference(model, robot, move)
    # Otherwise nothing but the smooth step is tested.
    assert run.events
    assert error(model, robot, move, run, 1) <= 1e-5
    assert error(model, robot, move, run, 5) <= 2e-7


@pytest.mark.slow
@both_models
def test_order_against_the_reference_is_near_three(model):
    cases = [(model, drawn(seed), move) for seed in range(4) for move in MOVES]
    runs = [reference(*case) for case in cases]
    errors = [
        [error(*case, run, parts) for parts in (1, 2, 4)]
        for case, run in zip(cases, runs, strict=True)
    ]
    # The mean over the runs: one event's place on the grid makes one run's error jump.
    means = np.log2(errors).mean(axis=0)
    assert (means[0] - means[-1]) / 2 >= 2.7


LEVEL = held((0, 60, [6.0, 6.0]), (110, 160, [-6.0, -6.0]), (180, 200, [9.0, 9.0]))


def level(robot):
    """A level move of the linear robot, out of line at the beginning."""
    start = State(START[:5], np.concatenate([START[5:9], [0.0]]))
    return ENGINES["linear"](robot, start, inputs_of(LEVEL, 1))


@pytest.mark.parametrize("torque", [0.02, 0.1, 0.3])
def test_equal_drives_on_a_level_move_are_so_much_friction_of_the_lower_carriage(torque):
    # Both drives and the carriage stop, turn, stick and give way in the same instants.
    for seed in range(8):
        robot = replace(
            drawn(seed), {"drive_friction": torque, "drive_friction_difference": 0.0}
        )
        lower, upper = robot.lower_carriage.friction, robot.upper_carriage.friction
        force = 2 * torque / robot.drive.effective_radius
        more = lower.coefficient + force / (4 * robot.cable.effective_pretension)
        alike = replace(robot, {"drive_friction": 0.0})
        alike = with_friction(alike, lower=Coulomb(more), upper=Coulomb(upper.coefficient))
        found, expected = level(robot).position, level(alike).position
        # Roundings of speeds of 1 m/s over a second, grown by the motion.
        assert np.abs(found - expected).max() <= 1e-11


@both_models
@pytest.mark.parametrize("difference", [-0.05, 0.0, 0.1])
def test_stuck_drives_don_t_creep_under_a_load_within_their_friction(difference, model):
    numbers = {"drive_friction": 0.2, "drive_friction_difference": difference}
    robot = replace(consistent(), numbers)
    start = rest(robot, *map(jnp.asarray, (0.80, 0.79, 0.45)))
    limits = np.asarray(robot.drive.frictions / robot.drive.torque_per_volt)
    inputs = inputs_of(np.tile(0.95 * limits * [1, -1], (STEPS, 1)), 1)
    states = ENGINES[model](robot, start, inputs)
    assert np.all(np.asarray(states.velocity)[:, 2:] == 0)
    assert np.all(np.ptp(np.asarray(states.position)[:, 2:], axis=0) == 0)


@both_models
def test_drives_outside_their_friction_move(model):
    robot = replace(consistent(), {"drive_friction": 0.2})
    start = rest(robot, *map(jnp.asarray, (0.80, 0.79, 0.45)))
    volts = 1.05 * 0.2 / float(robot.drive.torque_per_volt)
    inputs = inputs_of(np.tile([volts, -volts], (STEPS, 1)), 1)
    states = ENGINES[model](robot, start, inputs)
    assert float(states.position[-1, 4] - start.position[4]) > 1e-3
    # The lower carriage holds, so that the drives turn in opposite senses.
    assert np.all(states.velocity[:, 2] == 0)


@pytest.mark.parametrize("rate", [200, 1000])
def test_energy_never_rises_without_voltage(rate):
    inputs = stepping.Inputs(np.full(400, 1 / rate), np.zeros((400, 2)), np.zeros(400))
    start = State([0.62, 0.08, 0.59, 0.64, 0.5], [0.4, 0.3, -0.2, 0.5, 0.1])
    for seed in range(5):
        robot = drawn(seed)
        states = ENGINES["nonlinear"](robot, start, inputs)
        energies = np.asarray(jax.jit(jax.vmap(energy, in_axes=(None, 0)))(robot, states))
        # A step's own error, 1e-9 m, against forces of 2T = 170 N; and roundings.
        assert np.diff(energies).max() <= 1e-9 * 170


@functools.partial(jax.jit, static_argnums=0)
def derivatives(model, robot, voltage):
    """Derivatives by every quantity at 200 Hz and 1 kHz, at the reference's instants."""

    def positions(parts, values):
        named = replace(robot, dict(zip(NAMES, values, strict=True)))
        return simulated(model, named, inputs_of(voltage, parts)).position[::parts]

    values = jnp.stack([value(robot, name) for name in NAMES])
    return [jax.jacfwd(lambda v, p=parts: positions(p, v))(values) for parts in (1, 5)]


@pytest.mark.slow
@both_models
@pytest.mark.parametrize("seed", range(36))
def test_derivatives_are_the_references(seed, model):
    move, name = list(MOVES)[seed % len(MOVES)], NAMES[(4 + seed) % len(NAMES)]
    robot = drawn(100 + seed)
    centre = float(value(robot, name))
    width = 1e-5 * max(abs(centre), 1e-3)

    def places(steps):
        named = replace(robot, {name: centre + steps * width})
        return reference(model, named, move).positions

    outer, inner = places(2) - places(-2), places(1) - places(-1)
    truth = (8 * inner - outer) / (12 * width)
    both = derivatives(model, robot, MOVES[move])
    for found, bound in zip(both, (2e-3, 1e-4), strict=True):
        assert np.all(np.isfinite(found))
        own = found[..., NAMES.index(name)]
        assert np.abs(own - truth).max() <= bound * np.abs(truth).max()


@functools.partial(jax.jit, static_argnums=0)
def by_friction_at_zero(model, robot, inputs, weights):
    """Derivative of the positions by the drives' friction, and of a weighted sum of them."""

    def positions(torque):
        return simulated(model, replace(robot, {"drive_friction": torque}), inputs).position

    zero, one = jnp.zeros(()), jnp.ones(())
    forward = jax.jvp(positions, (zero,), (one,))[1]
    return forward, jax.grad(lambda torque: jnp.sum(weights * positions(torque)))(zero)


# The linear engine's takes a minute to compile.
@pytest.mark.parametrize("model", ["nonlinear", pytest.param("linear", marks=pytest.mark.slow)])
@pytest.mark.parametrize("move", ["horizontal", "diagonal", "again"])
def test_derivative_by_the_drives_friction_is_one_sided_at_zero(move, model):
    robot = replace(drawn(0), {"drive_friction": 0.0, "drive_friction_difference": 0.0})
    weights = np.random.default_rng(0).normal(size=(STEPS + 1, 5))
    found = by_friction_at_zero(model, robot, inputs_of(MOVES[move], 1), weights)
    forward, reverse = map(np.asarray, found)
    assert reverse == pytest.approx(np.sum(weights * forward), rel=1e-9)

    def places(torque):
        return reference(model, replace(robot, {"drive_friction": torque}), move).positions

    width = 1e-6
    truth = (places(width) - places(0.0)) / width
    # As the other derivatives at 200 Hz.
    assert np.abs(forward - truth).max() <= 2e-3 * np.abs(truth).max()
