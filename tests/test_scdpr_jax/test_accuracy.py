"""The fixed-grid engine held to the event-by-event reference, which is held to another one."""

import dataclasses
import json
import pathlib

import jax
import numpy as np
import pytest
from event_by_event import Numbers, simulate

from scdpr_jax import stepping
from scdpr_jax.dynamics import State
from scdpr_jax.friction import Coulomb
from scdpr_jax.parameters import replace, value, with_friction
from scdpr_jax.prototype import consistent

RUNS = pathlib.Path(__file__).parents[2].parent / "shared" / "data" / "stick_slip"
ROUNDING = {
    "breakaway": 0.0,
    "diagonal-reversals": 5e-6,
    "knock-at-rest": 0.0,
    "torque-step": 0.0,
}
"""Half of the last of the recorded voltages' six digits, where these aren't round [V]."""
FREE = ("friction_coefficient", "drive_inertia", "drive_damping", "effective_pretension")
GRID = 5e-3
"""Interval of the reference's inputs [s]."""
STEPS = 400
"""Their number: a torque step of a second, and a second of coasting."""
VOLTAGE = np.where(np.arange(STEPS)[:, None] < STEPS // 2, [6.0, 4.5], 0.0)
START = np.concatenate([[0.40, 0.0, 0.40, 0.40, 0.45], np.zeros(5)])


def numbers_of(robot):
    frictions = {
        "lower_friction": robot.lower_carriage.friction.coefficient,
        "upper_friction": robot.upper_carriage.friction.coefficient,
    }
    return Numbers(
        **{
            field.name: float(
                frictions[field.name] if field.name in frictions else value(robot, field.name)
            )
            for field in dataclasses.fields(Numbers)
        }
    )


def drawn(seed):
    """A robot within ±30 % of the prototype, its carriages of different friction."""
    random = np.random.default_rng(seed)
    robot = consistent()
    factors = random.uniform(0.7, 1.3, len(FREE))
    values = {name: float(value(robot, name)) for name in FREE}
    robot = replace(robot, {n: f * values[n] for n, f in zip(FREE, factors, strict=True)})
    lower, upper = robot.lower_carriage.friction.coefficient * random.uniform(0.7, 1.3, 2)
    return with_friction(robot, lower=Coulomb(lower), upper=Coulomb(upper))


@jax.jit
def stepped(robot, inputs):
    return stepping.simulate(robot, State(START[:5], START[5:]), inputs).position


def positions(robot, parts):
    """Positions at the reference's instants, by `parts` steps in each of its intervals."""
    inputs = stepping.Inputs(
        np.full(parts * STEPS, GRID / parts),
        np.repeat(VOLTAGE, parts, axis=0),
        np.zeros(parts * STEPS),
    )
    return np.asarray(stepped(robot, inputs))[::parts]


def error(robot, found, truth):
    """Largest error of a position [m]; the tilt moves the attachments, by the longer arm."""
    arm = max(numbers_of(robot).lower_offset, numbers_of(robot).upper_offset)
    return np.abs((found - truth) * np.array([1.0, arm, 1.0, 1.0, 1.0])).max()


def reference(robot):
    duration = np.full(STEPS, GRID)
    states, sticks = simulate(numbers_of(robot), START, duration=duration, voltage=VOLTAGE)
    # Otherwise nothing but the smooth step is tested.
    assert 0 < sticks.mean() < 1
    return states[:, :5]


@pytest.mark.parametrize("name", ROUNDING)
def test_the_reference_agrees_with_another_event_located_integrator(name):
    path = RUNS / f"{name}.csv"
    if not path.exists():
        pytest.skip("the shared reference runs are not beside this repository")
    rows = np.genfromtxt(path, delimiter=",", skip_header=1, max_rows=1200)
    described = json.loads(path.with_suffix(".json").read_text())
    numbers = {k: float(v.split()[0]) for k, v in described.items() if isinstance(v, str)}
    numbers["effective_radius"] *= 1e-3
    robot = numbers_of(replace(consistent(), numbers))
    states, sticks = simulate(
        robot,
        rows[0, 4:14],
        duration=np.diff(rows[:, 0]),
        voltage=rows[:-1, 1:3],
        knock=rows[:-1, 3],
    )
    # The records are good to 1e-12 m. Two voltages that err all along by their rounding
    # drive the lower carriage, and nothing but its mass resists.
    time = rows[:, 0]
    push = 2 * ROUNDING[name] * robot.torque_per_volt / robot.effective_radius
    allowed = 2e-12 + push / robot.masses[2] * time**2 / 2
    assert np.all(np.abs(states[:, :5] - rows[:, 4:9]).max(axis=1) <= allowed)
    assert np.array_equal(sticks, rows[1:, 14:16] == 1)


def test_the_reference_notices_a_wrong_limit():
    robot = drawn(0)
    wrong = dataclasses.replace(
        numbers_of(robot), upper_friction=1.01 * numbers_of(robot).upper_friction
    )
    duration = np.full(STEPS, GRID)
    states, _ = simulate(wrong, START, duration=duration, voltage=VOLTAGE)
    assert np.abs(states[:, :5] - reference(robot)).max() > 1e-4


@pytest.mark.parametrize(
    "seed", [*range(3), *(pytest.param(s, marks=pytest.mark.slow) for s in range(3, 16))]
)
def test_errors_are_within_bounds_at_200_hz_and_1_khz(seed):
    robot = drawn(seed)
    truth = reference(robot)
    coarse, fine = (error(robot, positions(robot, parts), truth) for parts in (1, 5))
    assert coarse <= 1e-5
    assert fine <= 2e-7


@pytest.mark.slow
def test_order_against_the_reference_is_near_three():
    errors = np.array(
        [
            [error(robot, positions(robot, parts), truth) for parts in (1, 2, 4, 8)]
            for robot, truth in ((r, reference(r)) for r in map(drawn, range(8)))
        ]
    )
    # The mean over the robots: one event's place on the grid makes one robot's error jump.
    means = np.log2(errors).mean(axis=0)
    assert (means[0] - means[-1]) / 3 >= 2.7
