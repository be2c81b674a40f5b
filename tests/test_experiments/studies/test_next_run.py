"""What `scdpr design` reads, prints and writes; the search itself is identification's."""

import dataclasses
import json

import jax
import numpy as np
import pytest

from experiments import cli
from experiments.studies.known_rig import caution, errors, known_rig
from experiments.studies.next_run import (
    aim_for,
    candidate_table,
    chosen_sentence,
    instructions,
    voltage_table,
)
from experiments.verbs.exit_status import BAD_INPUT
from identification.next_run.excitation import Excitation
from identification.next_run.next_experiment import Candidate
from identification.result.fitted_robot import Residual
from identification.result.parameters_file import ParametersDocument, read_parameters
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import QUANTITIES, value

NAMES = ["friction_coefficient", "drive_inertia", "effective_pretension 350 N"]
CORRELATION = [[1.0, 0.1, -0.9], [0.1, 1.0, 0.2], [-0.9, 0.2, 1.0]]
QUIET = (
    Residual(channel="alpha_1", rms=9e-5, noise_sigma=1e-4, is_noise=True),
    Residual(channel="x_e", rms=2e-4, noise_sigma=2e-4, is_noise=True),
)


def row(name, value, sigma, *, unit, setting=None, status="identified"):
    return {
        "name": name,
        "setting": setting,
        "value": value,
        "unit": unit,
        "sigma": sigma,
        "status": status,
    }


ROWS = (
    row("friction_coefficient", 0.013, 1e-5, unit="1"),
    row("drive_inertia", 0.0131, 2e-3, unit="kg m^2", status="weak"),
    row("effective_pretension", 85.0, 0.05, unit="N", setting="350 N"),
)
FIXED = tuple(
    row(
        known.name, float(value(consistent(), known.name)), 0.0, unit=known.unit, status="fixed"
    )
    for known in QUANTITIES
    if known.name not in {one["name"] for one in ROWS}
)


def document(rows=ROWS):
    return {
        "format": 1,
        "parameters": [*rows, *FIXED],
        "correlation": {"names": NAMES, "matrix": CORRELATION},
        "residuals": [dataclasses.asdict(one) for one in QUIET],
    }


def rig(rows=ROWS, setting=None):
    found = ParametersDocument.model_validate_json(json.dumps(document(rows))).fitted_robot()
    return known_rig(found, setting=setting, log_rate=1000.0, top_speed=1.5)


def sigmas(known):
    return np.sqrt(np.sum(np.square(np.asarray(known.root)), axis=1))


def test_what_is_known_of_a_rig_is_what_its_fit_reported():
    known = rig()
    assert known.names == tuple(one["name"] for one in ROWS)
    # Friction may be zero and is held as itself, the others as logarithms.
    np.testing.assert_allclose(sigmas(known), [1e-5, 2e-3 / 0.0131, 0.05 / 85.0], rtol=1e-9)


def test_what_is_known_keeps_its_correlation():
    root = np.asarray(rig().root)
    covariance = root @ root.T
    spread = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(covariance / np.outer(spread, spread), CORRELATION, atol=1e-9)


def test_a_setting_that_was_not_fitted_is_refused():
    with pytest.raises(ValueError, match="no effective pretension for '300 N'"):
        rig(setting="300 N")


def test_what_is_at_its_bound_is_taken_as_known():
    stopped = ROWS[0] | {"status": "at_bound"}
    assert "friction_coefficient" not in rig((stopped, *ROWS[1:])).names


def test_what_nothing_tells_is_known_within_a_factor_of_two():
    untold = ROWS[1] | {"sigma": None, "status": "unidentifiable"}
    assert sigmas(rig((ROWS[0], untold, ROWS[2])))[1] == pytest.approx(np.log(2))


def test_draws_scatter_as_what_is_known():
    known = rig()
    drawn = np.asarray(known.draws(jax.random.key(0), 4000))
    # The standard deviation of 4000 draws is within 5 % of its expectation at 4 sigma.
    np.testing.assert_allclose(drawn.std(axis=0), sigmas(known), rtol=0.05)


@pytest.mark.parametrize("wanted", ["mu", "friction_coefficient"])
def test_a_symbol_stands_for_the_name_of_its_quantity(wanted):
    assert aim_for(wanted, rig()).index == 0


def test_a_quantity_that_was_not_estimated_is_refused_by_name():
    with pytest.raises(ValueError, match="expected one of: friction_coefficient"):
        aim_for("drive_damping", rig())


LN2 = float(np.log(2.0))


def candidate(*, knock=0.0, designed=False, gain=LN2):
    voltage = np.zeros((100, 2))
    if not knock:
        voltage[30:60] = [6.0, -4.0]
    excitation = Excitation("torque step, aslant, 60%", (0.4, 0.55), voltage, knock, designed)
    return Candidate(excitation, np.array([5e-6, 0.1, 5e-4]), gain)


def test_the_table_has_a_row_each_millisecond_and_ends_at_rest():
    lines = voltage_table(candidate()).splitlines()
    assert lines[0] == "t [s],voltage_1 [V],voltage_2 [V]"
    assert lines[1 + 300] == "0.300,6,-4"
    assert lines[-1] == "1.000,0,0"
    assert len(lines) == 1 + 1001


def test_the_candidates_are_shown_with_intervals_and_limits():
    known = rig()
    table = candidate_table(known, aim_for("J", known), [candidate()])
    shown = dict(zip(table.header, table.rows[0], strict=True))
    assert table.title.endswith("95 % interval now ± 30 %")
    assert shown["with it"] == "± 20 %"
    assert shown["narrower by"] == "2.00"
    assert shown["log a second [1/s]"] == "0.693"
    assert shown["most [V]"] == "6.0"
    assert shown["reach x, y [m]"].startswith("0.40–")


def test_a_knock_is_described_and_voltages_are_not():
    (told,) = instructions(candidate(knock=45.0))
    assert "knock it sideways" in told
    (told,) = instructions(candidate())
    assert "at most 6.0 V" in told


def test_a_search_that_found_nothing_better_says_so():
    better = candidate(designed=True, gain=1.0)
    assert "1.44 times" in chosen_sentence([better, candidate()])
    worse = candidate(designed=True, gain=0.5)
    assert "nothing better" in chosen_sentence([candidate(), worse])


def test_residuals_that_are_noise_leave_the_sensors_as_they_are():
    assert errors(QUIET, 1000.0).encoder_sigma == 1e-4
    assert errors(QUIET, 1000.0).camera_position_sigma == 2e-4


def test_what_a_fit_leaves_beyond_noise_counts_once_while_it_stands():
    left = Residual(channel="alpha_1", rms=3e-3, noise_sigma=1e-4, is_noise=False)
    found = errors((left, *QUIET[1:]), 1000.0)
    # A hundred samples of 1 kHz in 0.1 s are worth one.
    assert found.encoder_sigma == pytest.approx(3e-2)
    assert found.camera_position_sigma == 2e-4
    assert caution((left,)).startswith("The fit leaves more than noise")


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        (["--for", "gravity"], "no such quantity, got 'gravity'"),
        (["--for", "mu", "--seconds", "0.5"], "Allow for a longer run"),
        (["--for", "mu", "--top-speed", "2"], "a number without its unit"),
        (["--for", "mu", "--setting", "200 N"], "no effective pretension"),
    ],
)
def test_bad_input_is_one_clear_message(tmp_path, capsys, changed, told):
    path = tmp_path / "parameters.json"
    path.write_text(json.dumps(document()))
    assert read_parameters(path).settings == ("350 N",)
    given = ["design", str(path), "--out", str(tmp_path / "next.csv"), *changed]
    assert cli.main(given) == BAD_INPUT
    assert told in capsys.readouterr().err
    assert not (tmp_path / "next.csv").exists()
