import math
import pathlib
import time

import good_campaign
import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from identification.campaign.faults import CampaignError
from identification.campaign.read import read_campaign
from identification.campaign.types import Initial, Knock

SHARED = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "campaigns"
needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="the shared campaigns are absent")


@pytest.fixture
def folder(tmp_path):
    return good_campaign.write(tmp_path / "small")


def test_what_is_known_of_the_rig_is_in_si(folder):
    campaign = read_campaign(folder)
    assert campaign.name == "small rig"
    assert campaign.counts_per_rev == 1000
    assert campaign.robot == {"effective_radius": 0.073, "friction_coefficient": 0.018}


def test_left_out_noise_is_the_rounding_to_counts_and_the_papers_camera(folder):
    sensors = read_campaign(folder).sensors
    assert sensors.encoder_sigma == 2 * math.pi / 1000 / math.sqrt(12)
    assert sensors.camera_position_sigma == 0.19e-3
    assert sensors.camera_angle_sigma == 1e-3


def test_encoder_noise_is_a_tenth_of_a_milliradian_where_counts_are_unknown(folder):
    (folder / "campaign.toml").write_text("format = 1")
    for drive in folder.glob("*/drive.csv"):
        drive.write_text(drive.read_text().replace("count", "rev"))
    campaign = read_campaign(folder)
    assert campaign.sensors.encoder_sigma == 1e-4
    assert campaign.counts_per_rev is None
    assert campaign.name == "small"


def test_a_run_says_what_was_done(folder):
    step, knock = read_campaign(folder).runs
    assert (step.name, step.kind, step.notes) == ("0001-step", "torque_step", "slow")
    assert (step.pretension, step.pretension_label) == (350.0, "350 N")
    assert step.initial == Initial(x_e=0.173, y_e=0.3, placement_sigma=1e-3)
    assert step.clock_offset == 0.002
    assert knock.knock == Knock(start=0.001, duration=0.001)
    assert knock.clock_offset is None
    assert knock.camera is None


def test_the_drives_stream_is_in_si_to_the_nearest_double(folder):
    drive = read_campaign(folder).run("0001-step").drive
    np.testing.assert_array_equal(drive.time, [0, 0.001, 0.002, 0.003])
    np.testing.assert_array_equal(drive.voltage[1], [1.5, -1.5])
    # A factor that isn't a power of ten rounds once more: two roundings of 2 pi.
    turn = 2 * math.pi
    assert np.max(np.abs(drive.angle[3] - [turn / 2, -turn])) <= 2 * np.spacing(turn)
    np.testing.assert_array_equal(drive.current[1], [0.012, 0.5])
    assert drive.tension is None
    assert drive.reference is None
    assert drive.extra == {}


def test_the_cameras_stream_is_in_the_models_order_with_nan_for_lost_markers(folder):
    camera = read_campaign(folder).run("0001-step").camera
    np.testing.assert_array_equal(camera.time, [0, 0.002, 0.004])
    expected = [0.027, 1.8 * (math.pi / 180), 0.027, math.nan, math.nan]
    np.testing.assert_array_equal(camera.position[1], expected)
    np.testing.assert_array_equal(camera.position[0], [0.026, 0, 0.026, 0.026, 0.3])


def test_optional_and_unknown_columns_are_kept(folder):
    text = (
        "t [s],voltage_1 [V],voltage_2 [V],alpha_1 [rad],alpha_2 [rad],"
        'tension [N],x_ref [cm],y_ref [m],air [degC],"who, where [1]"\n'
        '0,0,0,0,0,350,30,0.5,20.5,"A, lab"\n'
        "1,0,0,0,0,351,31,0.5,,B\n"
    )
    (folder / "0001-step" / "drive.csv").write_text(text)
    drive = read_campaign(folder).run("0001-step").drive
    np.testing.assert_array_equal(drive.tension, [350, 351])
    np.testing.assert_array_equal(drive.reference, [[0.3, 0.5], [0.31, 0.5]])
    np.testing.assert_array_equal(drive.extra["air [degC]"], [20.5, math.nan])
    assert drive.extra["who, where [1]"].tolist() == ["A, lab", "B"]


@pytest.mark.parametrize(
    "change",
    [
        pytest.param(lambda text: "\ufeff" + text, id="byte order mark"),
        pytest.param(lambda text: text.replace("\n", "\r\n"), id="CRLF"),
        pytest.param(lambda text: text + "\n\n", id="blank lines at the end"),
        pytest.param(lambda text: text.rstrip("\n"), id="no line end"),
        pytest.param(lambda text: text.replace(",", " , "), id="spaces"),
        pytest.param(lambda text: text.replace("1500", "1.5e+3"), id="exponents"),
        pytest.param(lambda text: text.replace("t [ms]", '"t [ms]"'), id="quotation marks"),
    ],
)
def test_dialects_of_the_same_table_read_the_same(folder, change):
    before = read_campaign(folder).run("0001-step").drive
    path = folder / "0001-step" / "drive.csv"
    path.write_bytes(change(path.read_text()).encode())
    after = read_campaign(folder).run("0001-step").drive
    np.testing.assert_array_equal(before.voltage, after.voltage)
    np.testing.assert_array_equal(before.angle, after.angle)
    np.testing.assert_array_equal(before.time, after.time)


# Writing and reading the files takes some 20 ms an example.
@hypothesis.settings(max_examples=50)
@hypothesis.given(
    value=st.floats(-1e6, 1e6),
    spaces=st.sampled_from(["", " "]),  # with one, the cell goes the careful way
    unit=st.sampled_from(["V", "mV"]),
)
def test_a_decimal_number_is_read_to_the_nearest_double(tmp_path_factory, value, spaces, unit):
    folder = good_campaign.write(tmp_path_factory.mktemp("campaign") / "small")
    header = f"t [s],voltage_1 [{unit}],voltage_2 [V],alpha_1 [rad],alpha_2 [rad]"
    rows = f"0,{value!r}{spaces},0,0,0\n1,0,0,0,0\n"
    (folder / "0001-step" / "drive.csv").write_text(f"{header}\n{rows}")
    exact = float(f"{value!r}e-3") if unit == "mV" and "e" not in repr(value) else None
    read = read_campaign(folder).run("0001-step").drive.voltage[0, 0]
    # Where the number has an exponent of its own, a quotient is within one rounding.
    expected = value if unit == "V" else value / 1000
    assert abs(read - expected) <= np.spacing(abs(expected))
    assert exact is None or read == exact


def test_folders_with_a_leading_point_are_no_runs(folder):
    (folder / ".git").mkdir()
    assert len(read_campaign(folder).runs) == 2


def test_a_bad_run_is_skipped_by_name_with_its_faults(folder):
    (folder / "0002-knock" / "drive.csv").unlink()
    campaign = read_campaign(folder, skip_bad_runs=True)
    assert [run.name for run in campaign.runs] == ["0001-step"]
    ((name, faults),) = campaign.skipped
    assert name == "0002-knock"
    assert [fault.what for fault in faults] == ["the file is missing"]


def test_nothing_is_skipped_in_a_good_campaign(folder):
    assert read_campaign(folder, skip_bad_runs=True).skipped == ()


def test_a_campaign_without_a_good_run_is_never_read(folder):
    for run in folder.glob("*/run.toml"):
        run.unlink()
    with pytest.raises(CampaignError) as caught:
        read_campaign(folder, skip_bad_runs=True)
    assert len(caught.value.faults) == 2


def test_a_fault_of_the_rigs_file_is_never_skipped(folder):
    (folder / "campaign.toml").write_text("format = 2")
    with pytest.raises(CampaignError, match=r"campaign\.toml"):
        read_campaign(folder, skip_bad_runs=True)


def test_runs_are_chosen_by_name(folder):
    campaign = read_campaign(folder)
    assert [run.name for run in campaign.with_runs(["0002-knock"]).runs] == ["0002-knock"]
    with pytest.raises(ValueError, match="no run 'x', expected one of: 0001-step, 0002-knock"):
        campaign.run("x")


@needs_shared
@pytest.mark.parametrize("rig", ["rig-a", "rig-b"])
def test_the_shared_campaigns_are_read_whole(rig):
    campaign = read_campaign(SHARED / rig)
    assert len(campaign.runs) == 14
    assert campaign.counts_per_rev == 26624
    assert campaign.robot == {"effective_radius": 0.073}
    for run in campaign.runs:
        lines = (SHARED / rig / run.name / "drive.csv").read_text().splitlines()
        assert len(run.drive.time) == len(lines) - 1
        assert (run.camera is None) == (run.kind == "motor_step")
        assert (run.clock_offset is None) == (rig == "rig-b" and run.camera is not None)


@needs_shared
def test_a_shared_campaign_agrees_with_numpys_own_reader():
    run = read_campaign(SHARED / "rig-a").run("0001-torque-step")
    folder = SHARED / "rig-a" / run.name
    drive = np.loadtxt(folder / "drive.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(run.drive.time, drive[:, 0])
    np.testing.assert_array_equal(run.drive.voltage, drive[:, 1:3])
    np.testing.assert_array_equal(run.drive.angle, drive[:, 3:] * (2 * math.pi / 26624))
    camera = np.loadtxt(folder / "camera.csv", delimiter=",", skiprows=1)
    millimetres = run.camera.position[:, [0, 4, 2, 3]] * 1e3
    # A quotient and a product: two roundings of some metres in millimetres.
    assert np.max(np.abs(millimetres - camera[:, [1, 2, 4, 5]])) <= 2 * np.spacing(2e3)


@needs_shared
def test_a_campaign_of_fourteen_runs_is_read_within_a_second():
    read_campaign(SHARED / "rig-a")
    # The processor's time, of this thread: other work on the machine doesn't count.
    start = time.thread_time()
    read_campaign(SHARED / "rig-a")
    assert time.thread_time() - start < 1
