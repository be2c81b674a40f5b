"""Good campaigns, whole and shortened, contradict nothing."""

import dataclasses
import pathlib

import loose_rig
import numpy as np
import pytest

from experiments.virtual_rig.rig import campaign as virtual_campaign
from experiments.virtual_rig.rig import draw_truth
from identification.campaign import Campaign, Run, read_campaign
from identification.doctor import examine

SHARED = pathlib.Path(__file__).parents[3].parent / "shared" / "data"


def contradictions(campaign: Campaign) -> list[str]:
    return [str(each) for each in examine(campaign) if each.severity != "note"]


def slow_log(run: Run) -> Run:
    """The same run logged at 100 Hz."""
    drive = run.drive
    every = max(1, round(0.01 / float(drive.time[1] - drive.time[0])))
    return dataclasses.replace(
        run,
        drive=dataclasses.replace(
            drive,
            time=drive.time[::every],
            voltage=drive.voltage[::every],
            angle=drive.angle[::every],
        ),
    )


def shortened(campaign: Campaign, random: np.random.Generator) -> dict[str, Campaign]:
    names = [run.name for run in campaign.runs]
    kinds = {run.kind for run in campaign.runs}
    parts = {kind: [r.name for r in campaign.runs if r.kind == kind] for kind in sorted(kinds)}
    parts["no knock"] = [r.name for r in campaign.runs if r.kind != "pseudo_impulse"]
    parts["one run"] = [str(random.choice(names))]
    parts["some runs"] = [str(name) for name in random.choice(names, 3, replace=False)]
    parts["x alone"] = [name for name in names if name[:4] in ("0001", "0002", "0005", "0011")]
    short = {what: campaign.with_runs(sorted(part)) for what, part in parts.items()}
    blank = tuple(dataclasses.replace(run, initial=None) for run in campaign.runs)
    short["no initial"] = dataclasses.replace(campaign, runs=blank)
    slow = tuple(map(slow_log, campaign.runs))
    short["100 Hz"] = dataclasses.replace(campaign, runs=slow)
    return short


def test_good_campaigns_contradict_nothing(good):
    assert [contradictions(campaign) for campaign in good] == [[]] * len(good)


@pytest.mark.parametrize("number", [1, 3])
def test_shortened_campaigns_contradict_nothing(good, number):
    for what, campaign in shortened(good[number], np.random.default_rng(number)).items():
        assert contradictions(campaign) == [], what


@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared campaigns are absent")
@pytest.mark.parametrize("rig", ["rig-a", "rig-b"])
def test_rigs_of_another_program_contradict_nothing(rig):
    assert contradictions(read_campaign(SHARED / "campaigns" / rig)) == []


@pytest.mark.slow
def test_the_virtual_rig_contradicts_nothing():
    for seed in range(4):
        assert contradictions(virtual_campaign(draw_truth(seed), seed)) == []


@pytest.mark.slow
def test_two_hundred_good_campaigns_contradict_nothing():
    for first in range(6000, 6200, 20):
        for campaign in loose_rig.campaigns(list(range(first, first + 20))):
            assert contradictions(campaign) == []


@pytest.mark.slow
def test_six_hundred_shortened_campaigns_contradict_nothing():
    random = np.random.default_rng(7)
    for first in range(6500, 6560, 20):
        for campaign in loose_rig.campaigns(list(range(first, first + 20))):
            for what, short in shortened(campaign, random).items():
                assert contradictions(short) == [], what
