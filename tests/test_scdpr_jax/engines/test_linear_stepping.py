"""The linear engine: exact between events, differentiable through them, batched."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from jax.test_util import check_grads

from scdpr_jax.engines.linear_stepping import linear_step, propagator, simulate_linear
from scdpr_jax.linear.model import linearise
from scdpr_jax.robot.parameters import smoothed
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import State, carriages

HEIGHT = 0.45
DURATION = 5e-3
ALIGNED = np.array([0.4, 0.0, 0.4, 0.4, HEIGHT])
AT_REST = State(ALIGNED, np.zeros(5))
VOLTAGE = jnp.repeat(jnp.array([[6.0, 4.5], [0.0, 0.0]]), 100, axis=0)


def run(robot, *, voltage=VOLTAGE, start=AT_REST, substeps=1):
    return simulate_linear(
        robot,
        start,
        height=jnp.asarray(HEIGHT),
        interval=jnp.asarray(DURATION),
        voltage=voltage,
        substeps=substeps,
    )


@pytest.mark.parametrize("duration", [1e-3, 5e-3, 25e-3])
@pytest.mark.parametrize("pretension", [85.0, 350.0])
def test_a_step_without_friction_is_the_matrix_exponential(duration, pretension):
    robot = replace(
        consistent(), {"friction_coefficient": 0.0, "effective_pretension": pretension}
    )
    robot = eqx.tree_at(lambda r: r.end_effector.knock_arm, robot, jnp.asarray(0.03))
    moved = np.array([0.01, 0.02, -0.01, 0.02, 0.0])
    start = State(ALIGNED + moved, [0.1, -0.2, 0.3, -0.1, 0.2])
    voltage, knock = jnp.array([3.0, -1.0]), jnp.asarray(5.0)
    tables = propagator(robot, height=jnp.asarray(HEIGHT), duration=jnp.asarray(duration))
    found = linear_step(robot, tables, start, voltage=voltage, knock=knock)

    space = linearise(robot, jnp.asarray(ALIGNED))
    forced = np.asarray(space.input_matrix) @ np.array([*voltage, knock])
    matrix = np.zeros((11, 11))
    matrix[:10] = np.column_stack([space.state_matrix, forced])
    ahead = np.concatenate([start.position - ALIGNED, start.velocity, [1.0]])
    expected = (scipy.linalg.expm(duration * matrix) @ ahead)[:10]
    difference = np.concatenate([found.position - ALIGNED, found.velocity]) - expected
    # A few roundings of the sums of places near 1 m times stiffnesses of 1e3 /s² times a step.
    assert np.abs(difference).max() <= 64 * np.finfo(float).eps * 1e3 * duration


@pytest.mark.slow
def test_substeps_are_steps():
    fine = run(consistent(), substeps=5)
    many = simulate_linear(
        consistent(),
        AT_REST,
        height=jnp.asarray(HEIGHT),
        interval=jnp.asarray(DURATION / 5),
        voltage=jnp.repeat(VOLTAGE, 5, axis=0),
    )
    assert jnp.max(jnp.abs(fine.position - many.position[::5])) <= 1e-14


@pytest.mark.slow
def test_tabulated_steps_make_up_the_run():
    robot = consistent()
    tables = propagator(robot, height=jnp.asarray(HEIGHT), duration=jnp.asarray(DURATION))
    state = AT_REST
    for voltage in VOLTAGE[:20]:
        state = linear_step(robot, tables, state, voltage=voltage, knock=jnp.asarray(0.0))
    assert jnp.max(jnp.abs(state.position - run(robot).position[20])) <= 1e-15


def test_a_carriage_that_sticks_rests_exactly():
    states = run(consistent(), voltage=jnp.zeros((50, 2)))
    assert jnp.all(states.carriages == ALIGNED[2])
    moving = run(consistent())
    assert jnp.all(carriages(moving.velocity[-1]) == 0)


@pytest.mark.parametrize("mode", ["fwd", pytest.param("rev", marks=pytest.mark.slow)])
def test_derivatives_hold_through_every_event(mode):
    names = (
        "friction_coefficient",
        "drive_inertia",
        "drive_damping",
        "effective_pretension",
    )
    nominal = jnp.array([0.0132, 1.27e-2, 0.212, 85.0])

    def places(logs):
        robot = replace(consistent(), dict(zip(names, nominal * jnp.exp(logs), strict=True)))
        return run(robot).position[::20, :4]

    # Differences of width 1e-6 of places of 1 m: rounding 1e-10; the curvature is small.
    check_grads(jax.jit(places), (jnp.zeros(4),), 1, (mode,), atol=1e-6, rtol=1e-5, eps=1e-6)


def test_a_batch_gives_what_single_runs_give():
    frictions = jnp.array([0.005, 0.013, 0.02])

    def one(friction):
        return run(replace(consistent(), {"friction_coefficient": friction})).position

    batch = jax.jit(jax.vmap(one))(frictions)
    alone = jnp.stack([jax.jit(one)(friction) for friction in frictions])
    assert jnp.max(jnp.abs(batch - alone)) <= 1e-13


def test_a_second_robot_is_not_compiled_anew():
    traced = []

    @eqx.filter_jit
    def final(robot):
        traced.append(None)
        return run(robot).position[-1]

    final(consistent())
    final(replace(consistent(), {"drive_inertia": 0.02}))
    assert len(traced) == 1


def test_a_smooth_friction_law_is_refused():
    with pytest.raises(TypeError, match=r"must be `Coulomb`.*scdpr_jax\.exact"):
        run(smoothed(consistent()))


def test_no_substep_is_refused():
    with pytest.raises(ValueError, match="`substeps` must be 1 or more"):
        run(consistent(), substeps=0)


@pytest.mark.slow
def test_steps_of_200_hz_follow_fine_ones_for_every_stiff_robot():
    # A carriage that creeps off and comes to rest again in one step was once thrown back:
    # one robot of sixty-four was then a millimetre off.
    random = np.random.default_rng(5)
    nominal = np.array([0.005, float(consistent().drive.inertia), 350.0])
    names = ("friction_coefficient", "drive_inertia", "effective_pretension")
    drawn = jnp.asarray(nominal * random.uniform(0.7, 1.3, (64, 3)))

    def place(values, substeps):
        robot = replace(consistent(), dict(zip(names, values, strict=True)))
        voltage = jnp.repeat(jnp.array([[6.0, 4.5], [0.0, 0.0]]), 40, axis=0)
        return simulate_linear(
            robot,
            AT_REST,
            height=jnp.asarray(HEIGHT),
            interval=jnp.asarray(25e-3),
            voltage=voltage,
            substeps=substeps,
        ).position

    coarse, fine = (
        jax.jit(jax.vmap(lambda values, parts=parts: place(values, parts)))(drawn)
        for parts in (5, 50)
    )
    assert np.abs(coarse - fine).max() <= 1e-5
