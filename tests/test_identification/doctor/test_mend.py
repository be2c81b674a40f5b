"""A mended campaign passes, and is what it was before the slip."""

import dataclasses

import numpy as np
import planted_slips
import pytest

from identification.campaign import read_campaign, write_campaign
from identification.doctor import examine
from identification.doctor.mend import mend

MENDED = (
    "degrees labelled rad",
    "mm labelled m",
    "drive ms as s",
    "motor 2",
    "y downwards",
    "motors",
    "carriages",
    "radius is diameter",
    "offset of 0.2 s",
    "wraps at a turn",
    "clock jump",
    "no knock",
    "knock at 0.75 s",
    "lost as 0",
    "same run twice",
    "cut start",
    "before the limit",
)


@pytest.mark.parametrize(
    "slip",
    [
        pytest.param(slip, marks=[pytest.mark.slow] if number % 2 else [])
        for number, slip in enumerate(MENDED)
    ],
)
def test_a_mended_campaign_passes(good, slip, tmp_path):
    wanted, plant = planted_slips.PLANTED[slip]
    slipped = plant(good[1], np.random.default_rng(5))
    done = mend(slipped, tmp_path / "mended")
    assert wanted in {finding.id for finding in done}
    again = examine(read_campaign(tmp_path / "mended"))
    assert [each for each in again if each.severity != "note" or each.id == wanted] == []


def test_a_mended_unit_gives_the_signals_back_and_a_note(good, tmp_path):
    slipped = planted_slips.PLANTED["y downwards"][1](good[1], np.random.default_rng(5))
    mend(slipped, tmp_path / "mended")
    run, was = read_campaign(tmp_path / "mended").runs[2], good[1].runs[2]
    assert np.allclose(run.camera.position, was.camera.position, atol=1e-12, equal_nan=True)
    assert "sign.y_e" in run.notes


def test_currents_go_with_exchanged_motors(good, tmp_path):
    run = good[1].runs[0]
    current = np.stack([np.ones(len(run.drive.time)), 2 * np.ones(len(run.drive.time))], axis=1)
    drive = dataclasses.replace(run.drive, current=current)
    campaign = dataclasses.replace(
        good[1], runs=(dataclasses.replace(run, drive=drive), *good[1].runs[1:])
    )
    swapped = planted_slips.PLANTED["motors"][1](campaign, np.random.default_rng(5))
    mend(swapped, tmp_path / "mended")
    assert read_campaign(tmp_path / "mended").runs[0].drive.current[0].tolist() == [2.0, 1.0]


def test_what_is_there_is_not_overwritten(good, tmp_path):
    write_campaign(good[1], tmp_path / "there")
    with pytest.raises(FileExistsError):
        mend(good[1], tmp_path / "there")
