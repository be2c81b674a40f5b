"""Values that can hardly be are told beside nameplate, setting and other measurements."""

import dataclasses
import json

import pytest
import report_samples
from report_samples import estimate

from experiments.reports.model_tables import measured_tables
from experiments.studies.findings.findings import findings
from experiments.studies.findings.plausibility import (
    ABOVE,
    implausible,
    settings_alike,
)
from identification.fit.unknowns.measured import MeasuredFit, MeasuredQuantity
from identification.fit.unknowns.options import FitOptions
from identification.judge.verdict import INERTIA_FACTOR
from identification.result.parameters_file import read_parameters, write_parameters
from scdpr_jax.robot.quantities import value

OWN = float(value(estimate().robot, "end_effector_mass"))


def told(*parameters):
    fitted = report_samples.estimate(parameters=parameters)
    return implausible(fitted, report_samples.campaign())


def parameters(*, inertia=0.0131, pretension=85.0):
    friction, drive, loop = report_samples.estimated_parameters()
    return (
        friction,
        dataclasses.replace(drive, value=inertia),
        dataclasses.replace(loop, value=pretension, interval95=(pretension, pretension)),
    )


def test_ordinary_values_are_not_remarked_on():
    assert told(*parameters()) == ()


def test_a_pretension_above_its_setting_is_told():
    (sentence,) = told(*parameters(pretension=743.0))
    assert "743 N at a setting of 350 N" in sentence
    assert told(*parameters(pretension=0.99 * ABOVE * 350)) == ()


def test_an_inertia_twice_the_nameplates_is_told():
    nameplate = 0.0127344
    (sentence,) = told(*parameters(inertia=1.1 * INERTIA_FACTOR * nameplate))
    assert "the drive inertia is" in sentence
    (sentence,) = told(*parameters(inertia=nameplate / INERTIA_FACTOR / 1.1))
    assert "of the nameplate's" in sentence


@pytest.mark.parametrize(("second", "told"), [(86.0, True), (140.0, False)])
def test_settings_that_the_fit_finds_to_be_one_are_told(second, told):
    friction, drive, loop = report_samples.estimated_parameters()
    low = dataclasses.replace(loop, setting="200 N", value=85.0)
    high = dataclasses.replace(loop, setting="350 N", value=second)
    fitted = report_samples.estimate(parameters=(friction, drive, low, high))
    sentences = settings_alike(fitted)
    assert bool(sentences) == told
    assert all("200 N and at 350 N" in sentence for sentence in sentences)


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
    write_parameters(path, report_samples.complete(found))
    (row,) = json.loads(path.read_text())["measured_otherwise"]
    assert row["name"] == "end_effector_mass"
    assert row["fitted"] == pytest.approx(row["value"] + 2 * row["sigma"])
    fit = MeasuredFit.of(found.options.measured[0], read_parameters(path).robot)
    assert fit.deviation == pytest.approx(2.0)
