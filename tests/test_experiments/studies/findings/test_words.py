import dataclasses

import equinox as eqx
import jax.numpy as jnp
import pytest
from report_samples import campaign, estimate, frequencies, parameter, skipped_run

from experiments.studies.findings.findings import findings
from experiments.studies.findings.predictions import predictions
from identification.fit.unknowns.options import FitOptions


def said(made, **changes):
    return findings(made, campaign=campaign(), **changes).words


def test_many_clocks_are_told_as_a_range():
    found = estimate()
    runs = campaign(clock=None).runs[:3]
    many = tuple(dataclasses.replace(runs[0], name=f"run {n}") for n in range(5))
    one = found.circumstances["0001-manoeuvre"]
    offsets = {
        run.name: eqx.tree_at(lambda c: c.clock_offset, one, jnp.asarray(0.01 * n))
        for n, run in enumerate(many, start=1)
    }
    told = findings(
        dataclasses.replace(found, circumstances=offsets),
        campaign=dataclasses.replace(campaign(), runs=many),
    ).words
    assert any("10.0 to 50.0 ms in 5 runs" in line for line in told.sure)


@pytest.mark.parametrize("drifts", [False, True])
def test_without_a_run_with_the_cable_on_no_clock_is_told(drifts):
    drives = dataclasses.replace(
        estimate(), circumstances={}, options=FitOptions(clock_drifts=drifts)
    )
    assert not any("clock" in line for line in said(drives).sure)


def test_drifting_clocks_are_told_as_a_range():
    told = said(dataclasses.replace(estimate(), options=FitOptions(clock_drifts=True))).sure
    assert any("run 0 to 0 ppm faster than the drives'" in line for line in told)


def test_what_the_data_do_not_tell_is_said_with_what_to_do():
    unknown = parameter("drive_damping", 0.2, 0.5, unit="N m s", status="unidentifiable")
    found = said(estimate(parameters=(*estimate().parameters[:2], unknown)))
    assert "Drive damping can't be told from these runs." in found.found
    assert any("Log runs that excite the drive damping" in step for step in found.next)


def test_what_may_be_zero_is_told_by_its_upper_end():
    nothing = parameter("drive_friction", 3e-6, 2e-6, unit="N m")
    lines = said(estimate(parameters=(*estimate().parameters[:2], nothing))).found
    assert (
        "Drive friction: 0.0000069 N m at the most (95 %); the runs don't ask for any." in lines
    )


def test_a_weak_estimate_is_called_weak():
    assert any("only weakly identified" in line for line in said(estimate()).found)


def test_a_fit_that_did_not_converge_is_said():
    found = estimate()
    fit = dataclasses.replace(found.fit, ended="unfinished")
    text = " ".join(said(dataclasses.replace(found, fit=fit)).sure)
    assert "used up its iterations" in text


def test_without_a_held_out_run_the_next_step_is_to_hold_one_out():
    steps = said(estimate(held_out=False)).next
    assert predictions(estimate(held_out=False)) == ()
    assert any("Hold a run out" in step for step in steps)


def test_a_known_clock_is_not_told():
    assert not any("clock" in line for line in said(estimate()).sure)


def test_an_unknown_clock_and_skipped_runs_are_told():
    found = findings(
        estimate(),
        campaign=campaign(clock=None, skipped=skipped_run()),
        frequencies=frequencies(),
    ).words
    text = " ".join(found.sure)
    assert "0001-manoeuvre 12.3 ms" in text
    assert "0009-x was skipped: 0009-x/drive.csv" in text
    assert any("one pose ring at 3.20 to 3.20 Hz" in line for line in found.found)
