import math

import nptdms
import numpy as np
import pytest
import scipy.io

from identification.bring.drive_log import import_drive_stream
from identification.campaign.faults import CampaignError

TIME = np.arange(5) * 1e-3
VOLTS = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
COUNTS = np.array([0, 10, 20, 30, 40], dtype=np.int32)
COLUMNS = {
    "t [ms]": "log/time",
    "voltage_1 [mV]": "log/u1",
    "voltage_2 [V]": "log/u2",
    "alpha_1 [count]": "log/n1",
    "alpha_2 [rad]": "log/a2",
    "air [degC]": "log/air",
}
CHANNELS = {
    "time": TIME * 1e3,
    "u1": VOLTS * 1e3,
    "u2": -VOLTS,
    "n1": COUNTS,
    "a2": COUNTS / 100,
    "air": VOLTS + 20,
}


def write_tdms(path, channels, properties=None):
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(
            [nptdms.ChannelObject("log", n, v, properties or {}) for n, v in channels.items()]
        )
    return path


def write_mat(path, channels):
    scipy.io.savemat(path, {"log": channels})
    return path


def dotted(columns):
    return {header: name.replace("/", ".") for header, name in columns.items()}


@pytest.fixture(params=["tdms", "mat"])
def log(request, tmp_path):
    """How to write a log of channels and how to read it, for both kinds of files."""
    path = tmp_path / f"run.{request.param}"
    write = {"tdms": write_tdms, "mat": write_mat}[request.param]
    rename = {"tdms": dict, "mat": dotted}[request.param]

    def read(channels, columns=COLUMNS, counts_per_rev=1000.0):
        write(path, channels)
        columns = rename(columns)
        return import_drive_stream(path, columns=columns, counts_per_rev=counts_per_rev)

    return read


def test_a_log_is_imported_in_si(log):
    drive = log(CHANNELS)
    # A product and a quotient with 1000: two roundings.
    assert np.max(np.abs(drive.time - TIME)) <= 2 * np.spacing(TIME[-1])
    assert np.max(np.abs(drive.voltage[:, 0] - VOLTS)) <= 2 * np.spacing(VOLTS[-1])
    np.testing.assert_array_equal(drive.voltage[:, 1], -VOLTS)
    np.testing.assert_array_equal(drive.angle[:, 0], COUNTS * (2 * math.pi / 1000))
    np.testing.assert_array_equal(drive.extra["air [degC]"], VOLTS + 20)
    assert drive.current is None


def test_a_channel_that_is_not_there_is_named_with_those_that_are(log):
    with pytest.raises(CampaignError, match=r"no such channel, got 'log.u3', .*log.u1"):
        log(CHANNELS, COLUMNS | {"tension [N]": "log/u3"})


def test_a_header_without_a_unit_is_a_fault(log):
    with pytest.raises(CampaignError, match="a column without a unit"):
        log(CHANNELS, COLUMNS | {"tension": "log/u2"})


def test_counts_need_the_counts_of_a_turn(log):
    with pytest.raises(CampaignError, match="counts_per_rev"):
        log(CHANNELS, counts_per_rev=None)


def test_channels_have_one_length(log):
    with pytest.raises(CampaignError, match="channels of different lengths"):
        log(CHANNELS | {"u2": VOLTS[:-1]})


def test_numbers_are_finite_and_time_increases(log):
    time, volts = TIME.copy(), VOLTS.copy()
    time[3], volts[2] = time[2] / 2, math.nan
    with pytest.raises(CampaignError) as caught:
        log(CHANNELS | {"time": time})
    (fault,) = caught.value.faults
    assert (fault.what, fault.row) == ("time doesn't increase", 4)
    with pytest.raises(CampaignError) as caught:
        log(CHANNELS | {"u2": volts})
    (fault,) = caught.value.faults
    assert (fault.what, fault.row) == ("not a finite number", 3)


def test_words_are_no_numbers(log):
    with pytest.raises(CampaignError, match=r"column 'voltage_2': not a channel of num"):
        log(CHANNELS | {"u2": np.array(["a", "b", "c", "d", "e"])})


def test_a_waveform_knows_its_time(tmp_path):
    channels = {name: CHANNELS[name] for name in ("u1", "u2", "n1", "a2")}
    properties = {"wf_increment": 1e-3, "wf_start_offset": 0.5, "wf_samples": 5}
    path = write_tdms(tmp_path / "run.tdms", channels, properties)
    columns = {header: name for header, name in COLUMNS.items() if name[4:] in channels}
    drive = import_drive_stream(path, columns=columns, counts_per_rev=1000.0)
    # A sum of some 0.5 s: a few roundings of it.
    assert np.max(np.abs(drive.time - (0.5 + TIME))) <= 4 * np.spacing(0.5)


def test_without_any_time_the_column_is_missing(tmp_path):
    path = write_tdms(tmp_path / "run.tdms", CHANNELS)
    columns = {header: name for header, name in COLUMNS.items() if header[0] != "t"}
    with pytest.raises(CampaignError, match="column 't': no clock"):
        import_drive_stream(path, columns=columns, counts_per_rev=1000.0)
