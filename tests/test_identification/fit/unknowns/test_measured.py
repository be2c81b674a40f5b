"""Numbers measured otherwise: what the robot makes of them, and how they are written."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from short_runs import bare_run

from identification.campaign import Campaign
from identification.campaign.types import default_sensors
from identification.fit.problem import Problem
from identification.fit.unknowns.measured import (
    MeasuredBreakaway,
    MeasuredFit,
    MeasuredFrequency,
    MeasuredQuantity,
)
from identification.fit.unknowns.measured_text import parse_measured
from identification.fit.unknowns.options import FitOptions
from identification.fit.unknowns.unknowns import DEFAULT_FREE
from scdpr_jax.engines.stepping import Inputs, simulate
from scdpr_jax.linear.modes import BOTH_HELD, held_frequency, natural_frequencies
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import rest

SETTING = "350 N"


def moves(robot, volts):
    """Whether the lower carriage ever moves under a voltage to both drives alike."""
    start = rest(robot, jnp.array(1.1), jnp.array(1.1), jnp.array(0.55))
    inputs = Inputs(jnp.full(40, 1e-3), jnp.full((40, 2), volts), jnp.zeros(40))
    return bool(jnp.any(simulate(robot, start, inputs).velocity[:, 2] != 0))


def test_the_breakaway_voltage_is_where_the_simulated_carriage_starts():
    robot = consistent()
    volts = float(MeasuredBreakaway(value=1.0, sigma=0.1, setting=SETTING).of(robot))
    assert not moves(robot, 0.999 * volts)
    assert moves(robot, 1.001 * volts)


def test_dry_friction_of_either_drive_raises_the_breakaway_voltage_by_half_of_itself():
    robot, one = consistent(), MeasuredBreakaway(value=1.0, sigma=0.1, setting=SETTING)
    uneven = replace(robot, {"drive_friction": 0.3, "drive_friction_difference": 0.2})
    per_volt = float(value(robot, "torque_per_volt"))
    rise = float(one.of(uneven) - one.of(robot))
    assert rise == pytest.approx((0.2 + 0.4) / (2 * per_volt), rel=1e-12)


def test_a_frequency_is_that_of_the_modes_and_scales_with_the_root_of_the_tension():
    robot, height = consistent(), jnp.asarray(0.4)
    sway = MeasuredFrequency(value=3.0, sigma=0.1, setting=SETTING, height=0.4)
    second = MeasuredFrequency(value=3.0, sigma=0.1, setting=SETTING, height=0.4, mode=1)
    assert float(sway.of(robot)) == pytest.approx(float(held_frequency(robot, height)))
    both = natural_frequencies(robot, height, BOTH_HELD)
    assert float(second.of(robot)) == pytest.approx(float(both[1]))
    tension = float(value(robot, "effective_pretension"))
    tighter = replace(robot, {"effective_pretension": 4 * tension})
    assert float(sway.of(tighter) / sway.of(robot)) == pytest.approx(2.0, rel=1e-9)


def test_a_deviation_is_in_standard_errors():
    one = MeasuredQuantity(quantity="drive_damping", value=0.2, sigma=0.01)
    damped = replace(consistent(), {"drive_damping": 0.23})
    assert MeasuredFit.of(one, damped).deviation == pytest.approx(3.0)


def problem(measured):
    runs = (bare_run("torque_step"),)
    campaign = Campaign(name="bare", runs=runs, sensors=default_sensors(10000.0))
    return Problem.of(campaign, FitOptions(measured=measured))


def test_normal_equations_of_numbers_measured_otherwise_are_those_of_their_residuals():
    label = bare_run("torque_step").pretension_label
    measured = (
        MeasuredQuantity(quantity="torque_per_volt", value=0.4, sigma=0.01),
        MeasuredQuantity(quantity="effective_pretension", value=90.0, sigma=5.0, setting=label),
        MeasuredBreakaway(value=1.5, sigma=0.1, setting=label),
        MeasuredFrequency(value=3.0, sigma=0.05, setting=label, height=0.4),
    )
    with jax.enable_x64(True):
        set_up = problem(measured)
        point = set_up.at_rest()
        normal = set_up.otherwise(point)
        step, slope = 1e-5, np.zeros_like(point)
        for index in range(point.size):
            shift = np.zeros_like(point)
            shift[index] = step
            costs = [set_up.otherwise(point + side * shift).cost for side in (1, -1)]
            slope[index] = (costs[0] - costs[1]) / (2 * step)
    # Half the gradient of the cost; curvature times the step squared is far below.
    np.testing.assert_allclose(2 * normal.gradient, slope, rtol=1e-6, atol=1e-4)
    # The tension and the frequency, which is as its root, tell the same.
    assert np.linalg.matrix_rank(normal.matrix) == 3
    expected = sum(
        MeasuredFit.of(one, set_up.prior).deviation ** 2 for one in measured
    )  # at the start, which is the prior robot
    assert normal.cost == pytest.approx(expected, rel=1e-9)


def test_a_measured_quantity_is_free_and_stands_once():
    inertia = MeasuredQuantity(quantity="drive_inertia", value=0.01, sigma=0.001)
    mass = MeasuredQuantity(quantity="end_effector_mass", value=2.0, sigma=0.01)
    assert FitOptions(measured=[inertia, mass]).all_free == (*DEFAULT_FREE, "end_effector_mass")


def test_a_setting_that_no_run_has_is_refused():
    one = MeasuredBreakaway(value=1.5, sigma=0.1, setting="123 N")
    with pytest.raises(
        ValueError, match=r"breakaway voltage was measured at '123 N', got runs"
    ):
        problem([one])


def test_written_numbers_are_read():
    quantity = parse_measured("drive_inertia = 0.01 kg m^2 +- 10 kg cm^2")
    assert (quantity.quantity, float(quantity.value)) == ("drive_inertia", 0.01)
    assert float(quantity.sigma) == pytest.approx(1e-3)
    tension = parse_measured("effective_pretension=71 N ± 2 N at 350 N")
    assert tension.setting == SETTING
    breakaway = parse_measured("breakaway_voltage = 1.8 V +/- 200 mV at 350 N")
    assert (float(breakaway.sigma), breakaway.setting) == (0.2, SETTING)
    frequency = parse_measured("natural_frequency = 3.2 Hz +- 0.02 Hz at 350 N, 550 mm")
    assert (float(frequency.height), frequency.setting) == (0.55, SETTING)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("friction_coefficient: 0.01", "can't be read"),
        ("friction_coefficient = 0.01", "can't be read"),
        ("friction_coeficient = 0.01 +- 0.001", "did you mean friction_coefficient"),
        ("friction_coefficient = 0.01 +- 0.001 at 350 N", "needs nothing after `at`"),
        ("effective_pretension = 71 N +- 2 N", "needs a pretension after `at`"),
        ("natural_frequency = 3 Hz +- 0.1 Hz at 350 N", "a pretension and a height"),
        ("drive_inertia = 0.01 kg m^2 +- 0 kg m^2", "standard error above zero"),
        ("drive_inertia = 0.01 kg m^2 +- 1", "number without its unit"),
    ],
)
def test_what_isn_t_a_measured_number_is_told(text, told):
    with pytest.raises(ValueError, match=told):
        parse_measured(text)
