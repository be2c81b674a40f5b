import dataclasses
import json

import pytest
from report_samples import estimate

from experiments.files.parameters_file import read_parameters, write_parameters
from experiments.reports.measured_section import contradictions, measured_tables
from identification.fit.unknowns.measured import MeasuredQuantity, deviation
from scdpr_jax.robot.parameters import value

OWN = float(value(estimate().robot, "end_effector_mass"))


def measured(*, off):
    """A weighing that is some standard errors below what the fit has."""
    weighed = MeasuredQuantity(quantity="end_effector_mass", value=OWN - 0.01 * off, sigma=0.01)
    return dataclasses.replace(estimate(), measured=(weighed,))


def test_what_was_measured_otherwise_stands_beside_the_fit():
    assert measured_tables(estimate()) == ()
    (table,) = measured_tables(measured(off=1.0))
    assert table.rows == (
        ("end effector mass", "", f"{OWN - 0.01:.3f}", "0.010", f"{OWN:.3f}", "kg", "1.00"),
    )


def test_only_what_the_logs_contradict_is_told():
    assert contradictions(measured(off=2.9)) == ()
    (told,) = contradictions(measured(off=4.0))
    assert "end effector mass" in told
    assert "4.0 of its standard errors off" in told


def test_the_file_holds_it_and_is_read_as_before(tmp_path):
    found, path = measured(off=2.0), tmp_path / "parameters.json"
    write_parameters(path, found)
    (row,) = json.loads(path.read_text())["measured_otherwise"]
    assert row["name"] == "end_effector_mass"
    assert row["fitted"] == pytest.approx(row["value"] + 2 * row["sigma"])
    assert deviation(found.measured[0], read_parameters(path).robot) == pytest.approx(2.0)
