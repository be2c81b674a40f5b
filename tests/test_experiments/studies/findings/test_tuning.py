import dataclasses

import numpy as np
import pytest
import report_samples

from experiments.studies.findings.tuning import tuning_sentences
from tuning.result.regional_shaper import ResidualVibration

RINGING = ResidualVibration(nominal=0.9, worst=1.0)


def told(**known):
    tuning = report_samples.tuning()
    regional = dataclasses.replace(tuning.shapers[0], residual_vibration=RINGING, **known)
    return " ".join(tuning_sentences(dataclasses.replace(tuning, shapers=(regional,))))


@pytest.mark.parametrize(
    ("known", "words"),
    [
        ({}, "don't count on the shaper alone there"),
        ({"kind": "own", "share": 0.2}, "Judge it by the random legs"),
    ],
)
def test_a_shaper_that_leaves_the_held_mode_says_what_to_judge_it_by(known, words):
    assert words in told(**known)


def test_a_shaper_that_cancels_its_mode_says_nothing_of_it():
    text = " ".join(tuning_sentences(report_samples.tuning()))
    assert "more than half" not in text
    assert np.all(
        [shaper.residual_vibration.nominal < 0.5 for shaper in report_samples.tuning().shapers]
    )
