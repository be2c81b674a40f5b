from functools import partial

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.trajectory import table_3
from scdpr_jax.engines import stepping
from scdpr_jax.engines.adaptive import (
    Adaptive,
    simulate_closed_loop,
    simulate_smooth,
    smooth_sensitivities,
)
from scdpr_jax.engines.closed_loop import closed_loop
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.dynamics import dampings, energy, pulley_rates
from scdpr_jax.robot.parameters import exact, smoothed
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import State, rest

ROBOT = consistent()
FRICTIONLESS = replace(smoothed(ROBOT), {"friction_coefficient": 0.0})
INTERVALS = 2000
TIMES = jnp.asarray(1e-3 * np.arange(INTERVALS + 1))
STEP = jnp.asarray(np.where((np.arange(INTERVALS) < 1000)[:, None], [9.0, 7.0], 0.0))
NO_KNOCK = jnp.zeros(INTERVALS)
STAIRS = 4 * jnp.sin(2 * jnp.pi * 1.3 * TIMES[:-1, None] + jnp.array([[0.0, 0.7]]))


def placed(lower, upper, height):
    return rest(ROBOT, jnp.asarray(lower), jnp.asarray(upper), jnp.asarray(height))


START = placed(0.3, 0.295, 0.4)


@jax.jit
def adaptive(robot, start, voltage, knock, tolerance):
    return simulate_smooth(
        robot,
        start,
        voltage=voltage,
        times=TIMES,
        knock=knock,
        save_at=TIMES,
        method=Adaptive(rtol=tolerance, atol=tolerance),
    )


@jax.jit
def fixed(robot, start, voltage, knock):
    return stepping.simulate(robot, start, stepping.Inputs(jnp.diff(TIMES), voltage, knock))


def solved(robot, start=START, voltage=STEP, knock=NO_KNOCK, tolerance=1e-10):
    return adaptive(robot, start, voltage, knock, jnp.asarray(tolerance))


@pytest.mark.slow
def test_energy_without_friction_and_damping_is_kept():
    robot = replace(FRICTIONLESS, {"drive_damping": 0.0})
    start = State([0.62, 0.08, 0.59, 0.64, 0.5], [0.0, 0.3, 0.0, 0.0, 0.1])
    states = solved(robot, start, jnp.zeros_like(STEP))
    energies = jax.vmap(energy, in_axes=(None, 0))(robot, states)
    # Steps' errors of 1e-10 against forces of 2T, some 500 of them.
    assert jnp.abs(energies - energies[0]).max() <= 500 * 1e-10 * 170


@jax.jit
def powers(robot, states, voltage):
    """Power of the drives' torques less that of the dampings [W]."""

    def power(velocity, command):
        driven = motor_torque(robot.drive, command) @ pulley_rates(robot, velocity)
        return driven - jnp.sum(dampings(robot) * velocity**2)

    return jax.vmap(power)(states.velocity, voltage)


def simpson(values):
    return (
        1e-3
        / 3
        * (values[0] + 4 * values[1:-1:2].sum() + 2 * values[2:-1:2].sum() + values[-1])
    )


def test_energy_gained_is_the_drives_work_less_the_damping():
    states = solved(FRICTIONLESS)
    gained = float(energy(FRICTIONLESS, jax.tree.map(lambda x: x[-1], states))) - float(
        energy(FRICTIONLESS, START)
    )
    # The power jumps with the voltage at 1 s: both halves apart.
    halves = [
        jax.tree.map(lambda x, part=part: x[part], states)
        for part in (slice(0, 1001), slice(1000, 2001))
    ]
    commands = [jnp.tile(STEP[:1], (1001, 1)), jnp.zeros((1001, 2))]
    work = sum(
        simpson(np.asarray(powers(FRICTIONLESS, half, command)))
        for half, command in zip(halves, commands, strict=True)
    )
    # Simpson's error, (w h)^4 / 180 at 8 Hz of 40 W for 2 s, beside the solver's.
    assert abs(gained - work) <= (2 * np.pi * 8 * 1e-3) ** 4 / 180 * 40 * 2 + 1e-6


def test_error_falls_with_the_tolerance():
    best = solved(FRICTIONLESS, tolerance=1e-13).position
    errors = [
        float(jnp.abs(solved(FRICTIONLESS, tolerance=tolerance).position - best).max())
        for tolerance in (1e-5, 1e-7, 1e-9)
    ]
    # Errors go about with the tolerance; each 100 times must give 20 at least.
    assert errors[0] > 20 * errors[1] > 400 * errors[2]
    # Local errors add up over 2 s: not more than a hundred of them.
    assert errors[2] <= 100 * 1e-9


def test_inputs_that_change_every_interval_are_held_exactly():
    knock = 5 * jnp.cos(7 * TIMES[:-1])
    found = solved(FRICTIONLESS, START, STAIRS, knock)
    expected = fixed(exact(FRICTIONLESS), START, STAIRS, knock)
    # The fixed grid's own error at 1 kHz without events, (w h)^4 of 8 Hz over 2 s.
    assert jnp.abs(found.position - expected.position).max() <= 2e-7


def test_bias_of_smoothed_friction_falls_in_proportion_to_its_width():
    truth = fixed(ROBOT, START, STEP, NO_KNOCK).position
    bias = [
        float(
            jnp.abs(solved(smoothed(ROBOT, width=width), tolerance=1e-8).position - truth).max()
        )
        for width in (1e-2, 1e-3, 1e-4)
    ]
    ratios = np.array(bias[:-1]) / bias[1:]
    # 10 in the limit; sticking ends and begins with a logarithm of the width.
    assert np.all((ratios > 6) & (ratios < 12))


def test_exact_friction_is_sent_to_the_fixed_grid():
    with pytest.raises(TypeError, match=r"lower_carriage.*Coulomb.*smoothed\(robot"):
        simulate_smooth(ROBOT, START, voltage=STEP, times=TIMES, save_at=TIMES)
    with pytest.raises(TypeError, match=r"lower_carriage.*Coulomb.*smoothed\(robot"):
        simulate_closed_loop(ROBOT, START, published_pd(), reference=jnp.ones((2, 2)))
    with pytest.raises(TypeError, match=r"lower_carriage.*Coulomb.*smoothed\(robot"):
        sensitive(ROBOT, jnp.zeros(3))


WANTED = np.array([0, 250, 1000, 2000])


@eqx.filter_jit
def in_few_steps(voltage):
    return simulate_smooth(
        FRICTIONLESS,
        START,
        voltage=voltage,
        times=TIMES,
        save_at=TIMES[WANTED],
        method=Adaptive(max_steps=1000),
    )


def test_grid_of_equal_inputs_costs_no_steps():
    # Two thousand intervals, one change: half as many steps are more than enough.
    assert jnp.all(jnp.isfinite(in_few_steps(STEP).position))


def test_states_are_saved_where_they_are_wanted():
    found, dense = in_few_steps(STEP), solved(FRICTIONLESS)
    # The default tolerance, 1e-7, in each of less than a thousand steps.
    assert jnp.abs(found.position - dense.position[WANTED]).max() <= 1000 * 1e-7


def test_solver_that_gives_up_says_so_under_jit():
    with pytest.raises(eqx.EquinoxRuntimeError, match=r"`max_steps`.*got 1000"):
        in_few_steps(STAIRS)


SCALES = jnp.ones(3)
WEIGHTS = jnp.array([1.0, 0.5, -1.0, 2.0, 1.0])


TIGHT = Adaptive(rtol=1e-10, atol=1e-10)


def weighted(scales, method=TIGHT):
    numbers = {"effective_pretension": 85 * scales[0], "drive_inertia": 0.0127 * scales[1]}
    robot = replace(smoothed(ROBOT, width=2e-2), numbers)
    final = simulate_smooth(
        robot,
        START,
        voltage=scales[2] * jnp.array([[9.0, 7.0], [0.0, 0.0]]),
        times=jnp.array([0.0, 0.3, 0.5]),
        save_at=jnp.array([0.5]),
        method=method,
    )
    return WEIGHTS @ final.position[0]


@pytest.fixture(scope="module")
def forward():
    """The value and its derivative along a direction, by forward mode."""

    def along(scales, direction):
        def value(scales):
            return weighted(
                scales, Adaptive(rtol=1e-10, atol=1e-10, adjoint=diffrax.ForwardMode())
            )

        return jax.jvp(value, (scales,), (direction,))

    return jax.jit(along)


def test_forward_derivatives_of_the_adaptive_solver_hold(forward):
    for unit in jnp.eye(3):
        _, slope = forward(SCALES, unit)
        above, below = forward(SCALES + 1e-3 * unit, unit), forward(SCALES - 1e-3 * unit, unit)
        # A relative step of 1e-3 squared, and 1e-10 of the solver's over it.
        assert abs(float(slope - (above[0] - below[0]) / 2e-3)) <= 1e-5
        assert abs(float(slope)) > 1e-3


@pytest.mark.slow
def test_reverse_derivatives_of_the_adaptive_solver_are_the_forward_ones(forward):
    found = jax.jit(jax.grad(weighted))(SCALES)
    slopes = jnp.stack([forward(SCALES, unit)[1] for unit in jnp.eye(3)])
    # Both differentiate the same steps.
    assert jnp.abs(slopes - found).max() <= 1e4 * np.finfo(float).eps


UNKNOWNS = ("friction_coefficient", "effective_pretension", "drive_inertia")
PUSH = {
    "voltage": jnp.array([[9.0, 7.0], [0.0, 0.0]]),
    "times": jnp.array([0.0, 0.2, 0.8]),
    "save_at": jnp.array([0.2, 0.8]),
    "method": Adaptive(rtol=1e-9, atol=1e-9),
}


def scaled(robot, logs):
    nominal = jnp.stack([value(ROBOT, name) for name in UNKNOWNS])
    return replace(robot, dict(zip(UNKNOWNS, nominal * jnp.exp(logs), strict=True)))


@jax.jit
def sensitive(robot, logs):
    return smooth_sensitivities(partial(scaled, robot), START, unknowns=logs, **PUSH)


# At the narrow width those through an adaptive solver's steps explode, docs/validity.md.
@pytest.mark.slow
@pytest.mark.parametrize("width", [1e-2, 1e-4])
@pytest.mark.parametrize("unknown", range(len(UNKNOWNS)))
def test_sensitivities_are_differences_of_the_motion(unknown, width):
    robot, shift = smoothed(ROBOT, width=width), 1e-4 * jnp.eye(3)[unknown]
    above, below = (sensitive(robot, logs).states.position for logs in (shift, -shift))
    found = sensitive(robot, jnp.zeros(3)).derivatives.position[:, unknown]
    # Some hundred steps of the tolerance over the difference.
    assert jnp.abs(found - (above - below) / 2e-4).max() <= 100 * 1e-9 / 1e-4
    assert jnp.abs(found).max() > 1e-2


@pytest.mark.slow
def test_sensitivities_come_with_the_motion_that_they_are_of():
    robot = smoothed(ROBOT, width=1e-2)
    alone = jax.jit(lambda robot: simulate_smooth(robot, START, **PUSH))(robot)
    found = sensitive(robot, jnp.zeros(3)).states
    assert jnp.abs(found.position - alone.position).max() <= 100 * 1e-9


@pytest.fixture(scope="module")
def references():
    trajectory = table_3(start_time=0.02, leg_times=(2.0, 2.25, 2.5)).diagonal
    return jax.vmap(trajectory.position)(TIMES[:601])


@pytest.mark.slow
def test_adaptive_closed_loop_approaches_exact_friction_with_the_width(references):
    start = placed(2.08, 2.081, 0.92)
    truth = jax.jit(
        lambda robot: closed_loop(robot, start, published_pd(), reference=references)
    )(ROBOT)
    smooth = jax.jit(
        lambda robot: simulate_closed_loop(robot, start, published_pd(), reference=references)
    )
    found = [smooth(smoothed(ROBOT, width=width)) for width in (1e-2, 1e-3)]
    bias = [float(jnp.abs(run.states.position - truth.states.position).max()) for run in found]
    # In proportion to the width, with the logarithm of the time that it takes to stop.
    assert bias[0] > 6 * bias[1]
    # 1e-3 m/s for the manoeuvre's 0.6 s.
    assert bias[1] <= 1e-3 * 0.6


@pytest.mark.slow
def test_stiff_solver_agrees_with_the_explicit_one():
    def final(solver):
        return simulate_smooth(
            smoothed(ROBOT, width=1e-3),
            START,
            voltage=jnp.array([[9.0, 7.0]]),
            times=jnp.array([0.0, 0.2]),
            save_at=jnp.array([0.2]),
            method=Adaptive(solver),
        ).position

    explicit, implicit = (
        jax.jit(final, static_argnums=0)(s) for s in (diffrax.Tsit5(), diffrax.Kvaerno5())
    )
    # Some hundred steps of the default tolerance, 1e-7.
    assert jnp.abs(explicit - implicit).max() <= 100 * 1e-7
