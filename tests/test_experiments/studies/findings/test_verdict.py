"""The verdict on a fit that has failed names the likeliest cause first."""

import dataclasses

import report_samples

from experiments.studies.findings.findings import findings
from experiments.studies.findings.verdict import doubts, verdict
from identification.judge.uncertainty import DOES_NOT_FIT
from identification.judge.verdict import Unexplained, judged

ACCEPTED = ("accepted contradiction: sign.y_e, 0001-manoeuvre: slope -1. It counts downwards.",)
LEFT_OUT = "Leave it out"


def failed(*places, accepted=()):
    """An estimate whose channels at (run, channel) aren't explained."""
    good = report_samples.estimate()
    channels = tuple(Unexplained(run, channel, 400.0, 0.5) for run, channel in places)
    parameters = judged(good.parameters, failed=True, contradicted=False)
    return dataclasses.replace(
        good,
        fitted=dataclasses.replace(good.fitted, parameters=parameters),
        unexplained=channels,
        accepted=accepted,
    )


def test_a_good_fit_has_no_verdict():
    assert verdict(report_samples.estimate(), report_samples.campaign()) == ()


def test_an_accepted_contradiction_is_the_likeliest_cause():
    first, *_ = verdict(failed(("0001-manoeuvre", "y_e"), accepted=ACCEPTED), None)
    assert first.startswith("THE MODEL DOES NOT FIT. The likeliest cause: the contradiction")
    assert "sign.y_e. The camera's vertical axis counts downwards" in first


def test_a_run_that_alone_is_not_explained_is_to_be_left_out():
    run = "0003-pseudo-impulse"
    first, *_ = verdict(failed((run, "x_e"), (run, "alpha_1")), None)
    assert run in first
    assert LEFT_OUT in first


def test_a_channel_that_alone_is_not_explained_is_named():
    first, *_ = verdict(failed(("a", "q_4"), ("b", "q_4")), None)
    assert "The likeliest cause: q_4" in first


def test_encoders_camera_and_everything_are_told_apart():
    encoders = failed(("a", "alpha_1"), ("b", "alpha_2"))
    camera = failed(("a", "x_e"), ("b", "y_e"))
    everything = failed(("a", "alpha_1"), ("b", "y_e"))
    told = {verdict(estimate, None)[0] for estimate in (encoders, camera, everything)}
    assert len(told) == 3
    assert not any(LEFT_OUT in line for line in told)


def test_the_figures_of_the_worst_channels_follow():
    _, figures, _ = verdict(failed(("a", "x_e"), ("b", "y_e")), None)
    assert "a, xₑ: 400 times the noise, 50 % of its motion" in figures


def test_a_failed_fit_advises_nothing_but_to_find_the_cause():
    estimate = failed(("a", "x_e"), ("b", "y_e"))
    told = findings(estimate, campaign=report_samples.campaign())
    assert told.verdict[0].startswith("THE MODEL DOES NOT FIT")
    assert len(told.words.next) == 1
    assert all(
        "may be off by anything" in line
        for line, p in zip(told.words.found, estimate.fitted.estimated, strict=False)
        if p.status == DOES_NOT_FIT
    )


def test_doubts_are_told_where_a_contradiction_left_noise_only():
    good = dataclasses.replace(report_samples.estimate(), accepted=ACCEPTED)
    assert "sign.y_e" in doubts(good)[0]
    assert doubts(report_samples.estimate()) == ()


def test_knocks_that_are_there_are_not_asked_for():
    campaign = report_samples.campaign()
    kinds = [run.kind for run in campaign.runs]
    assert "pseudo_impulse" in kinds
    with_knocks = findings(report_samples.estimate(), campaign=campaign).words.next
    without = findings(report_samples.estimate()).words.next
    assert any("Map the natural frequencies" in line for line in with_knocks)
    assert not any(line.startswith("Log knocks") for line in with_knocks)
    assert any(line.startswith("Log knocks") for line in without)
