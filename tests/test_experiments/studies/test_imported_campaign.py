"""A campaign that was written by any program is fitted as if it had been logged in format 1."""

import dataclasses

import log_styles
import numpy as np
import pytest

from experiments.virtual_rig.recovery import campaign, draw
from identification.bring.campaign_import import import_campaign
from identification.bring.proposal.propose import propose_mapping
from identification.campaign.read import read_campaign
from identification.result.estimation import estimate

SEED = 3
ANSWERS = {'pretension = ""': 'pretension = "350 N"', 'unit = ""': 'unit = "rad"'}
"""What a person fills in, each at most once for both encoders."""


@pytest.fixture(scope="module")
def logged():
    made = campaign(draw(SEED), SEED)
    return made, {each.name: each for each in estimate(made).parameters}


def imported(made, kind, folder):
    """The campaign as it comes back from logs of a style, by a proposal that was filled in."""
    random = np.random.default_rng([8, log_styles.STYLES.index(kind)])
    style = log_styles.draw_style(kind, random, counts=False)
    files = [
        file
        for number, run in enumerate(made.runs)
        for file in log_styles.write_run(folder, run, style, random, 1.0, f"log{number:03d}")
    ]
    propose_mapping(files, folder / "m.toml")
    text = (folder / "m.toml").read_text(encoding="utf-8")
    for left_empty, answer in ANSWERS.items():
        text = text.replace(left_empty, answer)
    (folder / "m.toml").write_text(text, encoding="utf-8")
    import_campaign(folder / "m.toml", folder / "out")
    return read_campaign(folder / "out").runs


@pytest.mark.slow
@pytest.mark.parametrize("kind", log_styles.STYLES)
def test_any_style_is_fitted_to_the_same_parameters(logged, kind, tmp_path):
    made, told = logged
    runs = imported(made, kind, tmp_path)
    assert [run.kind for run in runs] == [run.kind for run in made.runs]
    # When it was knocked, a log says to a sample; names and settings are the person's.
    same = [
        dataclasses.replace(run, name=own.name, knock=own.knock, clock_offset=own.clock_offset)
        for run, own in zip(runs, made.runs, strict=True)
    ]
    for found in estimate(dataclasses.replace(made, runs=tuple(same))).parameters:
        wanted = told[found.name]
        # Times in ms are seconds to their last bit, and another last bit may lead the search
        # another way, which ends some millionths of a standard error away.
        assert abs(found.value - wanted.value) <= 1e-4 * wanted.sigma, found.name
        if wanted.value > 1e-4:
            assert found.value == pytest.approx(wanted.value, rel=1e-9), found.name
