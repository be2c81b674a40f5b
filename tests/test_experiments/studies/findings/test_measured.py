import dataclasses
import json

import pytest
from report_samples import complete, estimate

from experiments.reports.model_tables import measured_tables
from experiments.studies.findings.findings import findings
from identification.fit.unknowns.measured import MeasuredFit, MeasuredQuantity
from identification.fit.unknowns.options import FitOptions
from identification.result.parameters_file import read_parameters, write_parameters
from scdpr_jax.robot.quantities import value

OWN = float(value(estimate().robot, "end_effector_mass"))


def measured(*, off):
    """A weighing that is some standard errors below what the fit has."""
    weighed = MeasuredQuantity(quantity="end_effector_mass", value=OWN - 0.01 * off, sigma=0.01)
    return dataclasses.replace(estimate(), options=FitOptions(measured=[weighed]))


def test_what_was_measured_otherwise_stands_beside_the_fit():
    assert measured_tables(estimate().measured_fits) == ()
    (table,) = measured_tables(measured(off=1.0).measured_fits)
    assert table.rows == (
        ("end effector mass", "", f"{OWN - 0.01:.3f}", "0.010", f"{OWN:.3f}", "kg", "1.00"),
    )


def test_only_what_the_logs_contradict_is_told():
    def contradictions(made):
        return [line for line in findings(made).words.sure if "contradict" in line]

    assert contradictions(measured(off=2.9)) == []
    (told,) = contradictions(measured(off=4.0))
    assert "end effector mass" in told
    assert "4.0 of its standard errors off" in told


def test_the_file_holds_it_and_is_read_as_before(tmp_path):
    found, path = measured(off=2.0), tmp_path / "parameters.json"
    write_parameters(path, complete(found))
    (row,) = json.loads(path.read_text())["measured_otherwise"]
    assert row["name"] == "end_effector_mass"
    assert row["fitted"] == pytest.approx(row["value"] + 2 * row["sigma"])
    fit = MeasuredFit.of(found.options.measured[0], read_parameters(path).robot)
    assert fit.deviation == pytest.approx(2.0)
