"""A run states its own camera: read, written, and weighed by it."""

import dataclasses

import good_campaign
import numpy as np
import pytest

from identification.campaign.extend import add_runs, state_camera
from identification.campaign.read import read_campaign
from identification.campaign.types import (
    CAMERA_COORDINATES,
    HEIGHT_OFFSET,
    CameraStream,
    DriveStream,
    Run,
    Sensors,
)
from identification.campaign.write import write_campaign
from identification.data.circumstances import NAMES
from identification.data.record import Reading, record
from identification.data.start import Clock, start_pose

OWN = {"x_e": 3.4e-5, "delta_e": 1.8e-4, "q_4": 5.9e-5}


@pytest.fixture
def folder(tmp_path):
    return good_campaign.write(tmp_path / "small")


def test_a_run_that_states_its_camera_has_it_and_the_others_the_campaigns(folder):
    assert state_camera(folder, "0001-step", OWN)
    campaign = read_campaign(folder)
    own, usual = (campaign.sensors.of_camera(run) for run in campaign.runs)
    place, angle = campaign.sensors.camera_position_sigma, campaign.sensors.camera_angle_sigma
    np.testing.assert_array_equal(usual, [place, angle, place, place, place])
    wanted = dict(zip(CAMERA_COORDINATES, usual, strict=True)) | OWN
    np.testing.assert_array_equal(own, [wanted[name] for name in CAMERA_COORDINATES])


def test_stating_it_again_changes_that_table_and_nothing_else(folder):
    file = folder / "campaign.toml"
    before = file.read_text() + "# measured twice\n"
    file.write_text(before)
    assert state_camera(folder, "0001-step", OWN)
    assert state_camera(folder, "0002-knock", {"x_e": 1e-3})
    assert file.read_text().startswith(before)
    assert state_camera(folder, "0001-step", {"y_e": 2e-4})
    assert file.read_text().startswith(before)
    first, second = read_campaign(folder).runs
    assert first.camera_sigma == {"y_e": 2e-4}
    assert second.camera_sigma == {"x_e": 1e-3}


@pytest.mark.parametrize(
    "text", [None, "format = ", '[sensors]\nruns = {0001-step = {x_e = "1 mm"}}\n']
)
def test_a_file_in_which_it_has_no_place_stays_as_it_is(tmp_path, text):
    if text is not None:
        (tmp_path / "campaign.toml").write_text(text)
    assert not state_camera(tmp_path, "0001-step", OWN)
    assert text is None or (tmp_path / "campaign.toml").read_text() == text


def test_a_run_with_an_odd_name_is_told_apart(tmp_path, folder):
    campaign = read_campaign(folder)
    name = 'a "b" é.c'
    run = dataclasses.replace(campaign.runs[0], name=name, camera_sigma=OWN)
    write_campaign(dataclasses.replace(campaign, runs=(run,)), tmp_path / "odd")
    assert read_campaign(tmp_path / "odd").run(name).camera_sigma == OWN


def test_runs_that_are_added_bring_theirs_along(tmp_path, folder):
    state_camera(folder, "0001-step", OWN)
    campaign = read_campaign(folder)
    more = dataclasses.replace(campaign.runs[0], name="0003-step", camera_sigma={"q_3": 1e-4})
    add_runs(dataclasses.replace(campaign, runs=(more,)), folder)
    read = read_campaign(folder)
    assert read.run("0001-step").camera_sigma == OWN
    assert read.run("0003-step").camera_sigma == {"q_3": 1e-4}


def stepped(camera_sigma):
    """A run in which both drives begin to turn at 0.1 s."""
    time, frames = 1e-3 * np.arange(400), 1e-2 * np.arange(1, 39)
    voltage = np.where(time > 0.1, 5.0, 0.0)[:, None] * np.ones(2)
    angle = 50.0 * np.maximum(time - 0.1, 0.0)[:, None] ** 2 * np.ones(2)
    return Run(
        name="0001-step",
        kind="torque_step",
        pretension=350.0,
        pretension_label="350 N",
        drive=DriveStream(time=time, voltage=voltage, angle=angle),
        camera=CameraStream(time=frames, position=np.ones((38, 5))),
        camera_sigma=camera_sigma,
    )


def test_a_fit_weighs_each_column_by_it():
    run, sensors = stepped(OWN), Sensors()
    made = record(run, Clock(0.0, 0.0), sensors, Reading(height=1.112, radius=0.073))
    weight = np.asarray(made.frame_weight)
    used = weight[:, 0] > 0
    assert used.any()
    np.testing.assert_array_equal(
        weight[used], np.tile(1 / sensors.of_camera(run), (used.sum(), 1))
    )
    # Frames at rest tell the start, by the same columns' deviations.
    start = start_pose(run, 0.0, sensors, 1.112)
    still = np.count_nonzero(~used)
    assert np.asarray(start.sigma)[1] == pytest.approx(OWN["q_4"] / np.sqrt(still), rel=0.1)


def test_heights_that_are_off_alike_tell_the_height_no_better_than_that():
    y_e, offset, sharing = 4e-5, 5e-5, 6
    run, sensors = stepped({"y_e": y_e, HEIGHT_OFFSET: offset}), Sensors()
    reading = Reading(height=1.112, radius=0.073, sharing=sharing)
    made = record(run, Clock(0.0, 0.0), sensors, reading)
    alone = record(stepped({"y_e": y_e}), Clock(0.0, 0.0), sensors, reading)
    weight, without = (np.asarray(each.frame_weight) for each in (made, alone))
    np.testing.assert_array_equal(weight[:, :4], without[:, :4])
    count = np.count_nonzero(weight[:, 4])
    of_mean = y_e**2 / count + sharing * offset**2
    assert (weight[:, 4] ** 2).sum() == pytest.approx(1 / of_mean, rel=1e-12)
    still = len(weight) - count
    wanted = np.hypot(y_e / np.sqrt(still), np.sqrt(sharing) * offset)
    told = 1 / float(made.prior.weight[NAMES.index("height")])
    assert told == pytest.approx(wanted, rel=1e-12)
