import json
import pathlib

import equinox as eqx
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st

from scdpr_jax.engines import stepping
from scdpr_jax.linear.modes import DRIVEN, natural_frequencies
from scdpr_jax.robot.dynamics import energy
from scdpr_jax.robot.parameters import smoothed
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import State, carriages, rest

RUNS = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "stick_slip"
NAMES = ("breakaway", "diagonal-reversals", "knock-at-rest", "torque-step")
ROBOT = consistent()
INTERVALS = 4000
"""Every grid is filled up to this many intervals by empty ones, to compile once."""


@jax.jit
def simulated(robot, start, inputs):
    return stepping.simulate(robot, start, inputs)


def on_grid(robot, start, duration, voltage, knock=None):
    """States at the ends of the intervals; `duration`'s length says how many there are."""
    count = len(duration)
    knock = np.zeros(count) if knock is None else knock
    fill = INTERVALS - count
    inputs = stepping.Inputs(
        np.pad(duration, (0, fill)),
        np.pad(voltage, ((0, fill), (0, 0))),
        np.pad(knock, (0, fill)),
    )
    states = simulated(robot, start, inputs)
    return jax.tree.map(lambda leaf: np.asarray(leaf)[: count + 1], states)


@jax.jit
def in_two(robot, start, inputs):
    return stepping.simulate(robot, start, inputs, substeps=2)


def test_substeps_are_the_steps_of_a_finer_grid():
    random, start = np.random.default_rng(3), placed(0.5, 0.55, 0.4)
    duration, voltage = np.full(100, 1e-2), random.uniform(-9, 9, (100, 2))
    coarse = in_two(ROBOT, start, stepping.Inputs(duration, voltage, np.zeros(100)))
    fine = on_grid(ROBOT, start, np.repeat(duration / 2, 2), np.repeat(voltage, 2, axis=0))
    np.testing.assert_allclose(coarse.position, fine.position[::2], atol=1e-11)
    np.testing.assert_allclose(coarse.velocity, fine.velocity[::2], atol=1e-9)


def placed(lower, upper, height):
    return rest(ROBOT, jnp.asarray(lower), jnp.asarray(upper), jnp.asarray(height))


@pytest.fixture(scope="module", params=NAMES)
def reference_run(request):
    path = RUNS / f"{request.param}.csv"
    if not path.exists():
        pytest.skip("the shared reference runs are not beside this repository")
    rows = np.genfromtxt(path, delimiter=",", skip_header=1)
    described = json.loads(path.with_suffix(".json").read_text())
    numbers = {k: float(v.split()[0]) for k, v in described.items() if isinstance(v, str)}
    numbers["effective_radius"] *= 1e-3
    states = on_grid(
        replace(ROBOT, numbers),
        State(rows[0, 4:9], rows[0, 9:14]),
        np.diff(rows[:, 0]),
        rows[:-1, 1:3],
        rows[:-1, 3],
    )
    return rows, states


def test_positions_are_an_event_located_integrators_to_a_micrometre(reference_run):
    rows, states = reference_run
    assert np.abs(states.position - rows[:, 4:9]).max() <= 1e-6


def test_carriages_stick_where_an_event_located_integrators_do(reference_run):
    rows, states = reference_run
    truth = rows[:, 14:16] == 1
    differing = (carriages(states.velocity) == 0) != truth
    changes = np.diff(truth, axis=0, prepend=truth[:1], append=truth[-1:])
    beside_an_event = changes[:-1] | changes[1:]
    assert not np.any(differing & ~beside_an_event)


def torque_step(count):
    """A torque step with a coast to rest, 1.6 s: slips, sticks and a break-away."""
    times = np.linspace(0, 1.6, count + 1)[:-1]
    voltage = np.where((times < 0.8)[:, None], [9.0, 7.0], 0.0)
    duration = np.full(count, 1.6 / count)
    return on_grid(ROBOT, placed(0.2, 0.19, 0.3), duration, voltage).position


def test_order_of_accuracy_is_three_through_stick_and_slip():
    fine = torque_step(4000)
    errors = [
        np.abs(torque_step(count) - fine[:: 4000 // count]).max() for count in (250, 500, 1000)
    ]
    # The finest, 1000, is 4 times as long as the reference, whose own error adds 1.6 %.
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders >= 2.7)


def swinging(tilt):
    """A robot of neither friction nor damping, off balance."""
    numbers = {"friction_coefficient": 0.0, "drive_damping": 0.0}
    return replace(ROBOT, numbers), State([0.62, tilt, 0.60, 0.60, 0.5], np.zeros(5))


def energy_loss_of_a_minute(robot, start):
    state = start
    for _ in range(15):
        states = on_grid(robot, state, np.full(INTERVALS, 1e-3), np.zeros((INTERVALS, 2)))
        state = State(states.position[-1], states.velocity[-1])
    return float(energy(robot, start)) - float(energy(robot, state))


def test_energy_without_friction_stays_within_1e_8_for_a_minute():
    robot, start = swinging(tilt=0.0)
    loss = energy_loss_of_a_minute(robot, start)
    assert abs(loss) <= 1e-8 * float(energy(robot, start))


def test_energy_of_the_fastest_swing_is_lost_as_the_method_says():
    robot, start = swinging(tilt=0.08)
    aligned = State([0.6, 0.0, 0.6, 0.6, 0.5], np.zeros(5))
    swing = float(energy(robot, start)) - float(energy(robot, aligned))
    fastest = 2 * np.pi * float(natural_frequencies(robot, jnp.asarray(0.5), DRIVEN)[-1])
    # Butcher's method keeps 1 - (w h)^6 / 2880 of an oscillation's energy in a step; the
    # frequency of swings of 0.1 rad is some percent off that of small ones.
    bound = 60_000 * (fastest * 1e-3) ** 6 / 2880 * 1.2
    assert 0 < energy_loss_of_a_minute(robot, start) <= bound * swing


def test_energy_never_rises_with_friction_and_no_input():
    start = State([0.62, 0.08, 0.59, 0.64, 0.5], [0.4, 0.3, -0.2, 0.5, 0.1])
    states = on_grid(ROBOT, start, np.full(2000, 1e-3), np.zeros((2000, 2)))
    states = State(states.position, states.velocity)
    energies = np.asarray(jax.jit(jax.vmap(energy, in_axes=(None, 0)))(ROBOT, states))
    # A step's own error, 1e-9 m, against forces of 2T = 170 N; and roundings.
    assert np.diff(energies).max() <= 1e-9 * 170


@hypothesis.settings(max_examples=10)
@hypothesis.given(
    # Compiled code flushes subnormal numbers to zero.
    st.lists(st.floats(-0.3, 0.3, allow_subnormal=False), min_size=5, max_size=5),
    st.floats(-10, 10, allow_subnormal=False),
)
def test_empty_interval_leaves_the_state_bit_for_bit(rates, voltage):
    start = State(jnp.array([1.0, 0.05, 1.04, 0.97, 0.4]), jnp.asarray(rates))
    states = on_grid(ROBOT, start, np.zeros(3), np.full((3, 2), voltage), np.full(3, 5.0))
    assert np.array_equal(states.position, np.tile(start.position, (4, 1)))
    assert np.array_equal(states.velocity, np.tile(start.velocity, (4, 1)))


def test_robot_within_the_friction_cone_stays_bit_for_bit():
    start = placed(1.0, 1.0 - 0.9 * 1.112 * 4.5 / (4 * 85), 0.5)
    states = on_grid(ROBOT, start, np.full(500, 1e-3), np.zeros((500, 2)))
    assert np.array_equal(carriages(states.velocity), np.zeros((501, 2)))
    # The end-effector hangs in balance up to roundings of the loop's 2T in 0.5 s.
    drift = np.abs(states.position - np.asarray(start.position)).max()
    assert drift <= 2 * 85 * 64 * np.finfo(float).eps / 0.025 * 0.5**2


def test_robot_outside_the_friction_cone_slides():
    start = placed(1.0, 1.0 - 1.1 * 1.112 * 4.5 / (4 * 85), 0.5)
    states = on_grid(ROBOT, start, np.full(500, 1e-3), np.zeros((500, 2)))
    assert np.all(np.abs(states.carriages[-1] - start.carriages) > 1e-5)


def test_smooth_friction_is_sent_to_the_adaptive_solvers():
    inputs = stepping.Inputs(jnp.ones(1), jnp.zeros((1, 2)), jnp.zeros(1))
    with pytest.raises(TypeError, match=r"lower_carriage.*SmoothCoulomb.*exact\(robot\)"):
        stepping.simulate(smoothed(ROBOT), placed(1.0, 1.0, 0.5), inputs)


@pytest.fixture(scope="module")
def fine_swing():
    robot, start = swinging(tilt=0.05)
    return on_grid(robot, start, np.full(4000, 5e-4), np.zeros((4000, 2)))


def thinned(states, stride):
    """The states and inputs of a grid that keeps every so manieth instant."""
    count = 4000 // stride
    kept = State(states.position[::stride], states.velocity[::stride])
    inputs = stepping.Inputs(
        np.full(count, 5e-4 * stride), np.zeros((count, 2)), np.zeros(count)
    )
    return kept, inputs


def between(states, inputs, fraction):
    count = inputs.duration.shape[0]
    return stepping.interpolate(
        states,
        inputs,
        interval=jnp.arange(count),
        fraction=jnp.full(count, fraction),
    )


def test_interpolation_meets_both_ends_of_an_interval(fine_swing):
    kept, inputs = thinned(fine_swing, 20)
    assert jnp.array_equal(between(kept, inputs, 0.0), kept.position[:-1])
    error = between(kept, inputs, 1.0) - kept.position[1:]
    # Five terms of a cubic of positions below 1 m.
    assert jnp.abs(error).max() <= 16 * np.finfo(float).eps


def test_interpolation_is_of_fourth_order_between(fine_swing):
    def error(stride):
        kept, inputs = thinned(fine_swing, stride)
        truth = fine_swing.position[stride // 2 :: stride]
        return np.abs(np.asarray(between(kept, inputs, 0.5)) - truth).max()

    orders = np.log2([error(40) / error(20), error(20) / error(10)])
    assert np.all((orders > 3.7) & (orders < 4.3))


SENSITIVE = {
    "friction_coefficient": 0.0132,
    "drive_inertia": 0.0127,
    "drive_damping": 0.2124,
    "effective_pretension": 85.0,
}
TIMES = 1e-3 * np.arange(1200)
PUSH = (
    np.where((TIMES < 0.5)[:, None], [9.0, 6.0], 0.0)
    - 3.0 * ((TIMES >= 0.5) & (TIMES < 0.6))[:, None]
)
MARKS = np.array([300, 700, 1200])


def scaled(scales):
    """Robot and start for four relative parameters and a start's three coordinates."""
    numbers = {
        name: SENSITIVE[name] * scale for name, scale in zip(SENSITIVE, scales, strict=False)
    }
    lower, upper, height = scales[4] * 0.3, scales[5] * 0.296, scales[6] * 0.4
    return replace(ROBOT, numbers), rest(ROBOT, lower, upper, height)


def marked_positions(scales):
    inputs = stepping.Inputs(np.full(1200, 1e-3), PUSH, np.zeros(1200))
    return stepping.simulate(*scaled(scales), inputs).position[MARKS]


@pytest.fixture(scope="module")
def central_differences():
    def positions(scales):
        return on_grid(*scaled(scales), np.full(1200, 1e-3), PUSH).position[MARKS]

    step = 1e-5
    columns = [
        (positions(1 + step * unit) - positions(1 - step * unit)) / (2 * step)
        for unit in jnp.eye(7)
    ]
    return np.stack(columns, axis=-1)


# The differences' own error at a relative step of 1e-5: roundings of 1 m, 1e-11, and the
# third derivative's, measured to fall by 100 from a step of 1e-4 (2e-7) to 1e-5 (2e-9).
DIFFERENCE_ERROR = 1e-8


def test_run_of_the_derivatives_sticks_and_slips():
    velocity = carriages(on_grid(*scaled(jnp.ones(7)), np.full(1200, 1e-3), PUSH).velocity)
    assert np.all(np.sum(np.diff(velocity == 0, axis=0), axis=0) >= 2)


def test_forward_derivatives_hold_through_every_event(central_differences):
    found = jax.jit(jax.jacfwd(marked_positions))(jnp.ones(7))
    assert np.abs(found - central_differences).max() <= DIFFERENCE_ERROR


def test_reverse_derivatives_hold_through_every_event(central_differences):
    weights = jnp.asarray(np.random.default_rng(0).normal(size=(3, 5)))
    found = jax.jit(jax.grad(lambda scales: jnp.sum(weights * marked_positions(scales))))(
        jnp.ones(7)
    )
    expected = np.einsum("ij,ijk->k", weights, central_differences)
    assert np.abs(found - expected).max() <= DIFFERENCE_ERROR * float(jnp.abs(weights).sum())


def test_runs_batch_over_robots_and_share_their_start():
    robots = eqx.filter_vmap(lambda T: replace(ROBOT, {"effective_pretension": T}))(
        jnp.array([60.0, 85.0])
    )
    inputs = stepping.Inputs(np.full(50, 1e-3), np.full((50, 2), 9.0), np.zeros(50))
    batch = jax.jit(jax.vmap(stepping.simulate, in_axes=(0, None, None)))
    states = batch(robots, placed(0.3, 0.3, 0.5), inputs)
    single = on_grid(ROBOT, placed(0.3, 0.3, 0.5), np.full(50, 1e-3), np.full((50, 2), 9.0))
    # Vectorised arithmetic may round differently; 50 steps of positions below 1 m.
    assert np.abs(states.position[1] - single.position).max() <= 50 * 8 * np.finfo(float).eps
