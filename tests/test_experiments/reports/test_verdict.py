import dataclasses
import math

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from report_samples import campaign, comparison, estimate, frequencies, parameter, skipped_run

from experiments.reports.verdict import (
    excesses,
    friction_forces,
    prediction,
    predictions,
    words,
)


def said(found, **changes):
    given = {"frequencies": None, "tuned": False} | changes
    return words(campaign(), found, **given)


def test_noise_alone_is_called_noise():
    assert excesses(estimate()) == ()
    # Five camera channels and two encoders in two fitted runs, two encoders in the third.
    assert "all 16 channels of 3 fitted runs" in said(estimate()).sure[0]


def test_residuals_beyond_noise_are_named_with_run_channel_and_size():
    text = said(estimate(off=5e-3)).sure[0]
    assert "NOT only noise: 1 of 16 channels of the 3 fitted runs" in text
    assert "0001-manoeuvre, xₑ: 5.0 mm rms (25 times the noise)" in text


def test_each_run_is_named_once_among_the_worst_and_the_worst_first():
    found = estimate(off=5e-3)
    first = found.comparisons[0]
    channels = tuple(dataclasses.replace(one, rms=9 * one.sigma) for one in first.channels)
    bad = dataclasses.replace(first, channels=channels)
    worse = tuple(dataclasses.replace(one, rms=11 * one.sigma) for one in channels)
    others = (dataclasses.replace(bad, name="0002-manoeuvre", channels=worse),)
    text = said(dataclasses.replace(found, comparisons=(bad, *others))).sure[0]
    assert text.count("0001-manoeuvre") == text.count("0002-manoeuvre") == 1
    assert text.index("0002-manoeuvre") < text.index("0001-manoeuvre")


def test_many_clocks_are_told_as_a_range():
    found = estimate()
    runs = campaign(clock=None).runs[:3]
    many = tuple(dataclasses.replace(runs[0], name=f"run {n}") for n in range(5))
    one = found.circumstances["0001-manoeuvre"]
    offsets = {
        run.name: eqx.tree_at(lambda c: c.clock_offset, one, jnp.asarray(0.01 * n))
        for n, run in enumerate(many, start=1)
    }
    told = words(
        dataclasses.replace(campaign(), runs=many),
        dataclasses.replace(found, circumstances=offsets),
        frequencies=None,
        tuned=False,
    )
    assert any("10.0 to 50.0 ms in 5 runs" in line for line in told.sure)


@pytest.mark.parametrize("drifts", [False, True])
def test_without_a_run_with_the_cable_on_no_clock_is_told(drifts):
    drives = dataclasses.replace(estimate(), circumstances={}, clock_drifts=drifts)
    assert not any("clock" in line for line in said(drives).sure)


def test_drifting_clocks_are_told_as_a_range():
    told = said(dataclasses.replace(estimate(), clock_drifts=True)).sure
    assert any("run 0 to 0 ppm faster than the drives'" in line for line in told)


def test_an_encoder_is_told_in_millimetres_of_cable():
    found = estimate()
    channels = found.comparisons[3].channels
    bad = dataclasses.replace(channels[0], rms=0.01)
    run = dataclasses.replace(found.comparisons[0], channels=(bad,))
    (excess,) = excesses(dataclasses.replace(found, comparisons=(run,)))
    radius = float(found.robot.drive.effective_radius)
    assert excess.size == pytest.approx(0.01 * radius, rel=1e-12)  # one multiplication


def test_a_held_out_run_is_no_reason_to_call_the_fit_bad():
    found = estimate()
    bad = dataclasses.replace(comparison("0001-manoeuvre", off=5e-3), held_out=True)
    assert excesses(dataclasses.replace(found, comparisons=(bad,))) == ()


def test_the_error_of_a_prediction_is_the_distance_in_the_plane():
    run = comparison("0001-manoeuvre", held_out=True)
    measured = run.simulated + np.array([3e-3, 0.0, 0.0, 0.0, 4e-3])
    one = prediction(dataclasses.replace(run, measured=measured), radius=0.073)
    assert one.error == pytest.approx(5e-3, rel=1e-9)  # differences of metres, in f64
    assert one.largest == pytest.approx(5e-3, rel=1e-9)
    moved = np.linalg.norm(np.ptp(run.simulated[:, [0, 4]], axis=0))
    assert one.share == pytest.approx(5e-3 / moved, rel=1e-9)


def test_frames_that_were_lost_are_left_out_of_a_prediction():
    run = comparison("0001-manoeuvre")
    lost = run.measured.copy()
    lost[::2] = np.nan
    one = prediction(dataclasses.replace(run, measured=lost), radius=0.073)
    assert math.isfinite(one.error)


def test_without_a_camera_the_encoders_say_how_good_a_prediction_is():
    run = comparison("0004-motor-step", camera=False)
    one = prediction(run, radius=0.073)
    noise = 0.073 * 1e-4 * math.sqrt(2)
    # Eight hundred draws: their root mean square is the noise within a tenth.
    assert one.error == pytest.approx(noise, rel=0.1)


def test_the_friction_force_is_surer_than_its_two_factors():
    (force,) = friction_forces(estimate())
    assert force.force == pytest.approx(4 * 85.0 * 0.013, rel=1e-12)  # two multiplications
    mu, tension = 1e-5 / 0.013, 0.05 / 85.0
    sigma = force.force * math.sqrt(mu**2 + tension**2 - 2 * 0.97 * mu * tension)
    # The normal distribution's factor for 95 %, to its printed digits.
    assert force.half_width == pytest.approx(1.95996 * sigma, rel=1e-5)


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
    found = words(
        campaign(clock=None, skipped=skipped_run()),
        estimate(),
        frequencies=frequencies(),
        tuned=True,
    )
    text = " ".join(found.sure)
    assert "0001-manoeuvre 12.3 ms" in text
    assert "0009-x was skipped: 0009-x/drive.csv" in text
    assert any("one pose ring at 3.20 to 3.20 Hz" in line for line in found.found)
