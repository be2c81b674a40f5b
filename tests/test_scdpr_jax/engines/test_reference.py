"""The event-by-event reference, held to another integrator's records and to closed forms."""

import dataclasses
import json
import pathlib

import jax.numpy as jnp
import numpy as np
import pytest
from event_by_event import Held, Linear, Nonlinear, simulate, slope
from robot_numbers import numbers_of
from share import share

from scdpr_jax.linear.model import linearise
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace

RUNS = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "stick_slip"
ROUNDING = {
    "breakaway": 0.0,
    "diagonal-reversals": 5e-6,
    "knock-at-rest": 0.0,
    "torque-step": 0.0,
}
"""Half of the last of the recorded voltages' six digits, where these aren't round [V]."""
NUMBERS = numbers_of(consistent())
HEIGHT = 0.5


def quiet(system, start, *, step, count):
    """A run without voltages and knocks."""
    return simulate(system, start, np.full(count, step), np.zeros((count, 2)), np.zeros(count))


@pytest.fixture(scope="module", params=share(ROUNDING, 2))
def record(request):
    """Name, numbers, rows and the reference's run of the first 1.2 s of a record."""
    path = RUNS / f"{request.param}.csv"
    if not path.exists():
        pytest.skip("the shared reference runs are not beside this repository")
    rows = np.genfromtxt(path, delimiter=",", skip_header=1, max_rows=1200)
    described = json.loads(path.with_suffix(".json").read_text())
    named = {k: float(v.split()[0]) for k, v in described.items() if isinstance(v, str)}
    named["effective_radius"] *= 1e-3
    numbers = numbers_of(replace(consistent(), named))
    run = simulate(
        Nonlinear(numbers),
        rows[0, 4:14],
        np.diff(rows[:, 0]),
        rows[:-1, 1:3],
        rows[:-1, 3],
    )
    return request.param, numbers, rows, run


def test_positions_are_another_event_located_integrators(record):
    name, numbers, rows, run = record
    # The records are good to 1e-12 m. Two voltages that err all along by their rounding
    # drive the lower carriage, and nothing but its mass resists.
    push = 2 * ROUNDING[name] * numbers.torque_per_volt / numbers.effective_radius
    allowed = 2e-12 + push / numbers.masses[2] * rows[:, 0] ** 2 / 2
    assert np.all(np.abs(run.positions - rows[:, 4:9]).max(axis=1) <= allowed)


def test_carriages_stick_in_the_rows_in_which_another_integrators_do(record):
    _, _, rows, run = record
    assert np.array_equal(run.sticks, rows[1:, 14:16] == 1)


# In its first 1.2 s this record has carriages that slide; another rests throughout.
@pytest.mark.parametrize("record", ["torque-step"], indirect=True)
def test_a_wrong_limit_misses_a_record(record):
    name, numbers, rows, _ = record
    wrong = dataclasses.replace(
        numbers,
        lower_friction=1.01 * numbers.lower_friction,
        upper_friction=1.01 * numbers.upper_friction,
    )
    inputs = np.diff(rows[:, 0]), rows[:-1, 1:3], rows[:-1, 3]
    run = simulate(Nonlinear(wrong), rows[0, 4:14], *inputs)
    push = 2 * ROUNDING[name] * numbers.torque_per_volt / numbers.effective_radius
    allowed = 2e-12 + push / numbers.masses[2] * rows[:, 0] ** 2 / 2
    assert np.any(np.abs(run.positions - rows[:, 4:9]).max(axis=1) > allowed)


TALL = 1e7
"""Height of a frame in which the cables stay upright: their angles are below 1e-7 [m]."""


@pytest.mark.parametrize("model", [Nonlinear, lambda numbers: Linear(numbers, TALL / 2)])
def test_blocks_slide_to_a_stop_as_the_closed_form_says(model):
    lower_drag, upper_drag, speed, slack = 3.0, 2.0, 0.4, 1e-12
    # Slack cables on rough guides: the carriages are two blocks that feel nothing else.
    numbers = dataclasses.replace(
        NUMBERS,
        frame_height=TALL,
        effective_pretension=slack,
        lower_friction=lower_drag / (4 * slack),
        upper_friction=upper_drag / (4 * slack),
    )
    start = np.array([0.0, 0.0, 0.0, 0.0, TALL / 2, 0.0, 0.0, speed, -speed, 0.0])
    run = quiet(model(numbers), start, step=0.15, count=8)

    _, _, lower_mass, upper_mass, _ = numbers.masses
    damping = 2 * numbers.drive_damping / numbers.effective_radius**2
    relax = lower_mass / damping
    lower_stop = relax * np.log1p(damping * speed / lower_drag)
    lower_way = relax * speed - lower_drag / damping * lower_stop
    upper_stop = speed * upper_mass / upper_drag
    stops = {event.contact: event for event in run.events}
    assert len(run.events) == 2
    assert all(event.after == 0 for event in run.events)
    forms = [[lower_stop, lower_way], [upper_stop, -speed * upper_stop / 2]]
    found = [[stops[i].time, run.positions[-1, 2 + i]] for i in range(2)]
    # DOP853's relative error of 1e-13 in each of its 240 steps, of ways below 1 m.
    assert np.abs(np.subtract(found, forms)).max() <= 240 * 1e-13


def test_a_stuck_drive_ties_the_carriage_to_the_height():
    speed, slack, slides, holds = 0.4, 1e-12, 0.05, 5.0
    # Slack cables, and a first drive that nothing turns: the second one unwinds both ways.
    numbers = dataclasses.replace(
        NUMBERS,
        frame_height=TALL,
        effective_pretension=slack,
        lower_friction=0.0,
        upper_friction=1.0,
        drive_frictions=(holds, slides),
    )
    start = np.array([0.0, 0.0, 0.0, 0.0, TALL / 2, 0.0, 0.0, speed, 0.0, -speed])
    run = quiet(Nonlinear(numbers), start, step=0.15, count=4)

    mass = numbers.masses[2] + numbers.masses[4]
    damping = 4 * numbers.drive_damping / numbers.effective_radius**2
    drag = 2 * slides / numbers.effective_radius
    relax = mass / damping
    stop = relax * np.log1p(damping * speed / drag)
    way = relax * speed - drag / damping * stop
    assert [event.after for event in run.events if event.contact == 3] == [0]
    ended = next(event.time for event in run.events if event.contact == 3)
    # As above.
    assert abs(ended - stop) <= 240 * 1e-13
    assert abs(run.positions[-1, 2] - way) <= 240 * 1e-13
    # Of a height of 5e6 m there are nine digits less.
    assert abs(run.positions[-1, 4] - start[4] + way) <= 1e-8


def swing():
    return np.array([0.62, 0.08, 0.59, 0.64, HEIGHT, 0.4, 0.3, -0.2, 0.5, 0.1])


@pytest.mark.parametrize("drives", [(0.0, 0.0), (0.05, 0.1)])
def test_energy_never_rises_with_friction_and_no_voltage(drives):
    system = Nonlinear(dataclasses.replace(NUMBERS, drive_frictions=drives))
    run = quiet(system, swing(), step=2e-3, count=400)
    states = np.concatenate([run.positions, run.velocities], axis=1)
    energies = np.array([system.energy(state) for state in states])
    assert len(run.events) >= 4
    # DOP853's relative error of 1e-13 in places below 1 m, against forces of 2T = 170 N.
    assert np.diff(energies).max() <= 1e-13 * 170


def test_linear_robot_is_the_packages_state_space():
    space = linearise(consistent(), jnp.array([0.6, 0.0, 0.6, 0.6, HEIGHT]))
    held = Held(duration=0.0, voltage=np.zeros(2), knock=0.0)
    system = Linear(dataclasses.replace(NUMBERS, lower_friction=0, upper_friction=0), HEIGHT)
    columns = [slope(system, unit, [1, 1], held) for unit in np.eye(10)]
    difference = np.column_stack(columns) - np.asarray(space.state_matrix)
    # A handful of roundings of the largest element.
    assert np.abs(difference).max() <= 16 * np.finfo(float).eps * np.abs(columns).max()
