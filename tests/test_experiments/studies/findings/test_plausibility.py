"""Values that can hardly be are told beside the nameplate and the setting."""

import dataclasses

import report_samples

from experiments.studies.findings.plausibility import ABOVE, FACTOR, implausible


def told(*parameters):
    estimate = report_samples.estimate(parameters=parameters)
    return implausible(estimate, report_samples.campaign())


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


def test_an_inertia_five_times_the_nameplate_is_told():
    nameplate = 0.0127344
    (sentence,) = told(*parameters(inertia=1.1 * FACTOR * nameplate))
    assert "the drive inertia is" in sentence
    (sentence,) = told(*parameters(inertia=nameplate / FACTOR / 1.1))
    assert "of the nameplate's" in sentence
