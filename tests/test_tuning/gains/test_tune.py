"""The whole of tuning, on a rig whose parameters are known."""

import types

import numpy as np
import pytest

from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.gains.tune import tune
from tuning.loop.admissible import PEAK_SENSITIVITY, PHASE_MARGIN

RIG_A = exact(
    replace(
        consistent(),
        {
            "effective_pretension": 85.166460,
            "friction_coefficient": 0.018270845,
            "drive_inertia": 0.014530930,
            "drive_damping": 0.20129864,
        },
    )
)
KNOCKS = types.SimpleNamespace(
    x=np.array([0.5549895, 1.111674, 1.1153355, 1.64751]),
    y=np.array([0.5422165, 0.559208, 0.8657980, 0.3023465]),
    pretension=np.full(4, 350.0),
    frequency=np.array([3.1451665, 3.1434531, 3.9619628, 3.6363721]),
    frequency_sigma=np.array([0.00076, 0.00064, 0.00524, 0.00852]),
    damping_ratio=np.array([0.00028, 0.0, 0.00398, 0.00683]),
)


@pytest.fixture(scope="module")
def tuning():
    return tune(types.SimpleNamespace(robot=RIG_A, of_setting=lambda label: RIG_A), KNOCKS)


@pytest.mark.slow
def test_the_vibration_after_two_second_legs_is_cut_by_three_fifths(tuning):
    prediction = tuning.predicted[0]
    assert prediction.after.residual_vibration <= 0.4 * prediction.before.residual_vibration


@pytest.mark.slow
@pytest.mark.parametrize("metric", ["resting_error", "largest_error", "rms_error"])
def test_no_error_of_two_second_legs_grows(tuning, metric):
    prediction = tuning.predicted[0]
    assert getattr(prediction.after, metric) <= getattr(prediction.before, metric)


@pytest.mark.slow
def test_the_flexible_robot_keeps_its_margins_everywhere(tuning):
    worst = {one.measure: one.value for one in tuning.worst_margins}
    assert worst["phase_margin"] >= PHASE_MARGIN
    assert worst["peak_sensitivity"] <= PEAK_SENSITIVITY


@pytest.mark.slow
def test_the_commands_stay_within_the_drives(tuning):
    assert tuning.predicted[0].after.largest_voltage <= float(RIG_A.drive.voltage_limit)


def test_nothing_is_tuned_for_a_robot_whose_fit_has_failed():
    failed = types.SimpleNamespace(robot=RIG_A, of_setting=lambda label: RIG_A, fits=False)
    with pytest.raises(ValueError, match="model_does_not_fit"):
        tune(failed, KNOCKS)
