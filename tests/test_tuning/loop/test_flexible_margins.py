import control
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from share import share

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.linear.model import linearise
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.loop.flexible_loop import (
    JOINT_LOOPS,
    LIFTING,
    UPPER_FREE,
    UPPER_HELD,
    controller_response,
    plants,
)
from tuning.loop.flexible_margins import flexible_margins
from tuning.loop.margins import sampled_margins
from tuning.loop.plant import MotorPlant
from tuning.loop.responses import sampled_loop
from tuning.loop.worst_margins import margin_map, worst_margins
from tuning.result.tuning import FittedSetting

PERIOD = 1e-3
ROBOT = exact(consistent())
PAIR = tuple(
    FittedSetting(nominal, replace(ROBOT, {"effective_pretension": tension}))
    for nominal, tension in ((200.0, 48.0), (350.0, 85.0))
)
FREE, LIFT = JOINT_LOOPS.index(UPPER_FREE), JOINT_LOOPS.index(LIFTING)

model_at = jax.jit(linearise)


def several(*trees):
    return jax.tree.map(lambda *leaves: np.stack(leaves), *trees)


@pytest.fixture(scope="module")
def published():
    return margin_map(PAIR, published_pd())


def state_space(robot, height):
    """The whole robot in the drives' sum and difference, from its linear model."""
    model = model_at(robot, jnp.asarray([0.0, 0.0, 0.0, 0.0, height]))
    both = np.array([[1.0, 1.0], [1.0, -1.0]])
    radius = float(robot.drive.effective_radius)
    angles = np.zeros((2, 10))
    angles[:, [2, 4]] = both / radius
    # Half the sum of the angles for the mean of the commands, and so with the difference.
    volts = np.asarray(model.input_matrix)[:, :2] @ both
    return np.asarray(model.state_matrix), volts, both @ angles / 2


def sampled_system(robot, height):
    """python-control's plant in sum and difference, a sample late."""
    return held(*state_space(robot, height), delay=1)


def held(a, b, c, *, delay):
    """A continuous plant behind a zero-order hold, by scipy, and some samples late."""
    size = sum(b.shape)
    both = np.zeros((size, size))
    both[: len(a)] = np.hstack([a, b])
    block = scipy.linalg.expm(PERIOD * both)
    plant = control.ss(block[: len(a), : len(a)], block[: len(a), len(a) :], c, 0, PERIOD)
    return plant * control.tf([1], [1, *[0] * delay], PERIOD)


def pd_of(controller):
    gain, slope = float(controller.proportional_gain), float(controller.derivative_gain)
    return control.tf([gain * PERIOD + slope, -slope], [PERIOD, 0], PERIOD)


def spectral_radius(height, loop, *, delay=1, factor=1.0):
    moving = [c for c in range(10) if loop.moving[c % 5]]
    channel = int(loop is LIFTING)
    a, b, c = state_space(PAIR[0].robot, height)
    parts = a[np.ix_(moving, moving)], b[moving, channel : channel + 1]
    system = held(*parts, c[channel : channel + 1, moving], delay=delay)
    opened = factor * system * pd_of(published_pd())
    closed = opened.A - opened.B @ opened.C / (1 + opened.D)
    return np.max(np.abs(np.linalg.eigvals(closed)))


@pytest.mark.parametrize("height", [0.19, 0.55, 0.92])
def test_sum_and_difference_of_the_drives_know_nothing_of_each_other(height):
    omega = np.geomspace(0.1, 3000.0, 60)
    response = sampled_system(ROBOT, height)(np.exp(1j * PERIOD * omega))
    own = np.abs(response[[0, 1], [0, 1]])
    across = np.abs(response[[0, 1], [1, 0]])
    # Roundings of a solve against a double integrator's lowest frequency.
    assert np.all(across <= 1e-9 * own)


def test_the_horizontal_position_does_not_matter():
    aside = model_at(ROBOT, jnp.asarray([0.7, 0.0, 0.7, 0.7, 0.4]))
    middle = model_at(ROBOT, jnp.asarray([0.0, 0.0, 0.0, 0.0, 0.4]))
    size = np.max(np.abs(middle.state_matrix))
    assert np.max(np.abs(aside.state_matrix - middle.state_matrix)) <= 1e-12 * size


@pytest.mark.parametrize("loop", share((UPPER_FREE, LIFTING), 1), ids=["sideways", "lifting"])
def test_margins_are_those_of_python_control(published, loop):
    row, column = 1, 7
    height, place = published.height[column], (JOINT_LOOPS.index(loop), row, column)
    channel = int(loop is LIFTING)
    system = sampled_system(PAIR[row].robot, height)[channel, channel]
    pd = pd_of(published_pd())

    def response(omega):
        return system(np.exp(1j * PERIOD * omega)) * pd(np.exp(1j * PERIOD * omega))

    omega = np.geomspace(1.0, 3141.5, 4001)
    frequencies = response(omega)
    closest = omega[np.argmin(np.abs(1 + frequencies))]
    distance = np.abs(1 + response(closest * np.linspace(0.998, 1.002, 1001)))
    found = control.stability_margins(control.frd(frequencies, omega), returnall=True)
    margins = jax.tree.map(lambda leaf: float(leaf[place]), published.flexible.margins)
    # Interpolated on steps of 2e-3 of the frequency.
    assert abs(np.degrees(margins.phase_margin) - np.min(np.abs(found[1]))) <= 0.02
    assert abs(margins.gain_margin / np.min(found[0][found[0] > 1]) - 1) <= 1e-3
    assert abs(margins.peak_sensitivity * np.min(distance) - 1) <= 1e-6


def test_a_loop_of_stiff_cables_is_that_of_a_rigid_robot():
    drive, radius = ROBOT.drive, ROBOT.drive.effective_radius
    carried = ROBOT.end_effector.mass + ROBOT.lower_carriage.mass + ROBOT.upper_carriage.mass
    inertia = drive.inertia + carried * radius**2 / 2
    viscous = ROBOT.lower_carriage.friction.viscous + ROBOT.upper_carriage.friction.viscous
    rigid = MotorPlant(
        gain=drive.torque_per_volt / inertia,
        pole=(drive.damping + viscous * radius**2 / 2) / inertia,
    )
    omega, pd = np.array([3.0, 10.0, 30.0, 60.0]), published_pd()
    expected = jax.vmap(lambda w: sampled_loop(rigid, pd, w))(jnp.asarray(omega))

    def error(tension):
        robot = replace(ROBOT, {"effective_pretension": tension})
        own, _ = plants(several(robot), np.array([0.5]), period=PERIOD)
        plant = own.response(np.full(4, FREE), np.expm1(1j * omega * PERIOD))
        controller = controller_response(several(pd), np.zeros(4, int), omega, delay=1)
        return np.max(np.abs(controller * plant / expected - 1))

    errors = [error(tension) for tension in (1e5, 1e7)]
    # What the cables give falls with their stiffness: squares of 60 rad/s over the modes'.
    assert errors[0] <= 0.05
    assert errors[1] <= 0.015 * errors[0]


def test_lifting_is_the_loop_of_a_drive_that_carries_the_end_effector(published):
    drive, radius = ROBOT.drive, ROBOT.drive.effective_radius
    inertia = drive.inertia + ROBOT.end_effector.mass * radius**2 / 2
    rigid = MotorPlant(gain=drive.torque_per_volt / inertia, pole=drive.damping / inertia)
    expected = jax.jit(sampled_margins)(rigid, published_pd())
    got = jax.tree.map(lambda leaf: leaf[LIFT], published.flexible.margins)
    for one, other in zip(jax.tree.leaves(got), jax.tree.leaves(expected), strict=True):
        # The plant's matrix exponential against its closed form.
        assert np.max(np.abs(np.asarray(one) / float(other) - 1)) <= 1e-6


@pytest.mark.parametrize("loop", [UPPER_FREE, UPPER_HELD], ids=["free", "held"])
@pytest.mark.parametrize("column", [0, 10, 20])
def test_margins_are_where_the_loop_turns_unstable(published, loop, column):
    height, place = published.height[column], (JOINT_LOOPS.index(loop), 0, column)
    gain = float(published.flexible.margins.gain_margin[place])
    assert spectral_radius(height, loop, factor=0.999 * gain) < 1
    assert spectral_radius(height, loop, factor=1.001 * gain) > 1
    spare = int(float(published.flexible.margins.delay_margin[place]) / PERIOD)
    assert spectral_radius(height, loop, delay=1 + spare) < 1
    assert spectral_radius(height, loop, delay=2 + spare) > 1


def test_the_worst_margins_are_named_with_their_pose(published):
    worst = {one.measure: one for one in worst_margins(published)}
    phase = np.asarray(published.flexible.margins.phase_margin)
    assert worst["phase_margin"].value == phase.min()
    column = int(np.flatnonzero(published.height == worst["phase_margin"].height)[0])
    names = [loop.name for loop in JOINT_LOOPS]
    row = [200.0, 350.0].index(worst["phase_margin"].pretension)
    assert phase[names.index(worst["phase_margin"].loop), row, column] == phase.min()


def test_an_unstable_loop_is_told_instead_of_a_margin():
    pd = published_pd()
    # Beyond the sideways loop's gain margin of 36.06, short of lifting's 41.4.
    found = margin_map(PAIR, PD(36.5 * pd.proportional_gain, 36.5 * pd.derivative_gain))
    assert np.all(np.isnan(np.asarray(found.flexible.margins.phase_margin)[FREE]))
    assert np.all(np.isfinite(np.asarray(found.flexible.margins.phase_margin)[LIFT]))
    (worst,) = worst_margins(found)
    assert worst.measure == "spectral_radius"
    assert worst.value > 1


def test_controllers_are_judged_side_by_side_as_alone():
    pd = published_pd()
    softer = PD(0.5 * pd.proportional_gain, pd.derivative_gain, filter_time=2e-3)
    robots, heights = several(ROBOT), np.array([0.3, 0.8])
    both = flexible_margins(robots, heights, several(pd, softer))
    for number, own in enumerate((pd, softer)):
        alone = flexible_margins(robots, heights, own)
        for one, other in zip(
            jax.tree.leaves(both.margins), jax.tree.leaves(alone.margins), strict=True
        ):
            np.testing.assert_allclose(one[number], other, rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "said"),
    [({"delay": -1}, "`delay` must not be negative"), ({}, "must have one period")],
)
def test_what_no_loop_can_have_is_refused(change, said):
    pd = published_pd()
    slower = PD(pd.proportional_gain, pd.derivative_gain, period=2e-3)
    with pytest.raises(ValueError, match=said):
        flexible_margins(several(ROBOT), np.array([0.5]), several(pd, slower), **change)
