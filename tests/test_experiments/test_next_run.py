import dataclasses

import numpy as np
import pytest
from report_samples import estimate, estimated_parameters

from experiments.next_run import (
    Left,
    candidate_table,
    caution,
    criterion_for,
    errors,
    instructions,
    known_rig,
    voltage_table,
)
from identification.excitation import Excitation
from identification.next_experiment import Candidate

CORRELATION = np.array([[1.0, 0.1, -0.9], [0.1, 1.0, 0.2], [-0.9, 0.2, 1.0]])


CHANNELS = (Left("alpha_1", 9e-5, 1e-4, True), Left("x_e", 2e-4, 2e-4, True))


def rig(rows=None, **changes):
    given = {
        "setting": "350 N",
        "channels": CHANNELS,
        "top_speed": 1.5,
    }
    rows = estimated_parameters() if rows is None else rows
    return known_rig(estimate().robot, rows, CORRELATION, **(given | changes))


def sigmas(known):
    return np.sqrt(np.diag(np.linalg.inv(np.asarray(known.earlier))))


def test_what_is_known_of_a_rig_is_what_its_fit_reported():
    known = rig()
    assert known.names == ("friction_coefficient", "drive_inertia", "effective_pretension")
    np.testing.assert_allclose(sigmas(known)[1:], [2e-3 / 0.0131, 0.05 / 85.0], rtol=1e-9)


def test_what_belongs_to_another_setting_is_left_unknown():
    known = rig(setting="300 N")
    assert "effective_pretension" not in known.names
    # Its correlation with the others stays in their errors.
    np.testing.assert_allclose(sigmas(known)[1], 2e-3 / 0.0131, rtol=1e-9)


def test_what_is_at_its_bound_is_taken_as_known():
    first, *others = estimated_parameters()
    known = rig((dataclasses.replace(first, status="at_bound", sigma=np.inf), *others))
    assert "friction_coefficient" not in known.names


def test_what_nothing_tells_is_known_to_its_size_only():
    first, second, third = estimated_parameters()
    untold = dataclasses.replace(second, sigma=np.inf, status="unidentifiable")
    assert sigmas(rig((first, untold, third)))[1] == pytest.approx(10.0)


def test_a_quantity_that_was_not_estimated_is_refused_by_name():
    with pytest.raises(ValueError, match="expected one of: friction_coefficient"):
        criterion_for("drive_damping", rig())


def candidate(*, knock=0.0):
    voltage = np.zeros((100, 2))
    if not knock:
        voltage[30:60] = [6.0, -4.0]
    excitation = Excitation("torque step, sideways, 60%", (0.4, 0.55), voltage, knock)
    return Candidate(excitation, np.array([5e-6, 0.1, 5e-4]), float(np.log(2.0)), False)


def test_the_table_has_a_row_each_millisecond_and_ends_at_rest():
    lines = voltage_table(candidate()).splitlines()
    assert lines[0] == "t [s],voltage_1 [V],voltage_2 [V]"
    assert lines[1 + 300] == "0.300,6,-4"
    assert lines[-1] == "1.000,0,0"
    assert len(lines) == 1 + 1001


def test_the_candidates_are_shown_with_errors_before_and_after():
    table = candidate_table(rig(), "drive_inertia", [candidate()])
    row = dict(zip(table.header, table.rows[0], strict=True))
    assert row["σ of drive inertia now"] == "15 %"
    assert row["with it"] == "10 %"
    assert row["smaller by a factor"] == "2.00"
    assert row["its logarithm a second [1/s]"] == "0.693"


def test_a_knock_is_described_and_voltages_are_not():
    (told,) = instructions(candidate(knock=45.0))
    assert "knock it sideways" in told
    (told,) = instructions(candidate())
    assert "at most 6.0 V" in told


def test_residuals_that_are_noise_leave_the_sensors_as_they_are():
    assert errors(CHANNELS).encoder_sigma == 1e-4
    assert errors(CHANNELS).camera_position_sigma == 2e-4


def test_what_a_fit_leaves_beyond_noise_counts_once_while_it_stands():
    found = errors((Left("alpha_1", 3e-3, 1e-4, False), *CHANNELS[1:]))
    # A hundred samples of 1 kHz in 0.1 s are worth one.
    assert found.encoder_sigma == pytest.approx(3e-2)
    assert found.camera_position_sigma == 2e-4


def test_a_prediction_from_a_fit_that_leaves_more_than_noise_says_so():
    (told,) = caution((Left("alpha_1", 3e-3, 1e-4, False),))
    assert told.startswith("The fit leaves more than noise")
