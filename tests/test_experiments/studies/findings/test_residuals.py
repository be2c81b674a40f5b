import dataclasses

import pytest
from report_samples import campaign, comparison, estimate

from experiments.studies.findings.findings import findings
from experiments.studies.findings.residuals import excesses


def said(made, **changes):
    return findings(made, campaign=campaign(), **changes).words


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
