"""Every reader of a file that somebody gives, with a good file of its kind."""

import csv
import dataclasses
import io
import pathlib
from collections.abc import Callable

import good_campaign
import h5py
import nptdms
import numpy as np
import scipy.io
from codesign_samples import co_design
from report_samples import complete, estimate
from tunings import plain

from identification.axis.log import read_axis_log
from identification.bring.acceleration import read_acceleration
from identification.bring.campaign_import import mapped_campaign
from identification.bring.proposal.propose import propose_mapping
from identification.campaign import check_campaign, read_campaign
from identification.doctor import examine
from identification.fit.unknowns.measured_text import parse_measured
from identification.knocks.frequency_map import read_frequencies
from identification.result.parameters_file import read_parameters, write_parameters
from identification.vision.settings.read import read_vision
from identification.vision.timing.clock import read_stamps
from scdpr_jax.robot.prototype import consistent
from tuning.codesign.codesign_file import read_law, write_codesign
from tuning.plan.legs_file import read_legs
from tuning.plan.plan_file import read_plan
from tuning.result.document import read_tuning, write_tuning
from tuning.shapers.spectrum_file import read_spectrum


@dataclasses.dataclass(frozen=True)
class Given:
    """A kind of file that is read."""

    name: str
    """What it is called here."""
    file: str
    """Its name in the folder that `write` fills."""
    read: Callable[[pathlib.Path], object]
    """What reads it, given that folder."""


def _check(folder):
    check = check_campaign(folder / "campaign")
    if check.campaign is not None:
        examine(check.campaign)
    read_campaign(folder / "campaign")


def _propose(folder):
    propose_mapping([folder / "log.csv"], folder / "proposal.toml")


def _measured(folder):
    parse_measured((folder / "measured.txt").read_bytes().decode("utf-8", "surrogateescape"))


def _own(name, read):
    return Given(name, name, lambda folder: read(folder / name))


CAMPAIGN = tuple(
    Given(f"campaign/{name}", f"campaign/{name}", _check)
    for name in (
        "campaign.toml",
        "0001-step/run.toml",
        "0001-step/drive.csv",
        "0001-step/camera.csv",
        "0001-step/accelerometer.csv",
        "0002-knock/run.toml",
    )
)
TEXTS = (
    *CAMPAIGN,
    _own("frequencies.csv", read_frequencies),
    _own("plan.csv", read_plan),
    _own("legs.csv", lambda path: read_legs(path, ROBOT)),
    _own("spectrum.csv", read_spectrum),
    _own("axis.csv", read_axis_log),
    _own("stamps.csv", read_stamps),
    _own("acceleration.csv", read_acceleration),
    _own("vision.toml", read_vision),
    Given(
        "mapping.toml", "mapping.toml", lambda folder: mapped_campaign(folder / "mapping.toml")
    ),
    Given("log.csv", "log.csv", lambda folder: mapped_campaign(folder / "mapping.toml")),
    Given("log.csv proposed", "log.csv", _propose),
    Given("measured text", "measured.txt", _measured),
)
RESULTS = (
    _own("parameters.json", read_parameters),
    _own("tuning.json", read_tuning),
    _own("codesign.json", read_law),
)
IN_CI = {"log.csv proposed": 1, **{own.name: 5 for own in CAMPAIGN}}
"""Mutants of a kind in CI's share, where it isn't the usual number."""
BINARY = ("log.tdms", "level5.mat", "packed.mat", "level4.mat", "hdf5.mat")
ROBOT = consistent()


def write(folder: pathlib.Path) -> pathlib.Path:
    """Write a good file of every kind but results, and return the folder."""
    campaign = good_campaign.write(folder / "campaign")
    seconds = np.arange(64) / 1e3
    table = [seconds, np.sin(40 * seconds), np.cos(30 * seconds)]
    accelerometer = _table(("t [s]", "a_x [m/s^2]"), table[:2])
    (campaign / "0001-step" / "accelerometer.csv").write_text(accelerometer)
    texts = {
        "frequencies.csv": "x [m],y [m],pretension [N],frequency [Hz],frequency_sigma [Hz],"
        "damping_ratio [1],damping_ratio_sigma [1],run\n0.3,0.5,350,3.1,0.01,0.02,0.001,0002\n",
        "plan.csv": "t [s],x_ref [m],y_ref [m],alpha_ref_1 [rad],alpha_ref_2 [rad],"
        "feedforward_1 [V],feedforward_2 [V]\n0,0.3,0.5,0,0,1,1\n0.001,0.3,0.5,0.1,0.1,1,1\n",
        "legs.csv": "x_from [m],y_from [m],x_to [m],y_to [m],leg_time [s]\n0.3,0.5,1.9,0.5,2\n",
        "spectrum.csv": _table(
            ("freq", "psd_x", "psd_xyz"), [np.arange(1.0, 40), *(np.hanning(39),) * 2]
        ),
        "axis.csv": _table(("t [s]", "voltage [V]", "position [mm]"), table),
        "stamps.csv": _table(("frame", "t [s]"), [np.arange(64), seconds]),
        "acceleration.csv": _table(("time [s]", "accel_x [g]", "accel_y [g]"), table),
        "log.csv": _table(
            ("time [s]", "u1 [V]", "u2 [V]", "enc1 [deg]", "enc2 [deg]"), [*table, *table[1:]]
        ),
        "mapping.toml": MAPPING,
        "vision.toml": VISION,
        "measured.txt": "natural_frequency = 3.2 Hz +- 0.02 Hz at 350 N, 0.55 m",
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    _write_binary(folder, seconds)
    return folder


def _write_binary(folder, seconds):
    struct = {"t": seconds, "Rig": {"u": np.sin(seconds), "note": "rig A"}}
    scipy.io.savemat(folder / "level5.mat", {"log": struct})
    scipy.io.savemat(folder / "packed.mat", {"log": struct}, do_compression=True)
    scipy.io.savemat(folder / "level4.mat", {"t": seconds, "u": np.sin(seconds)}, format="4")
    with h5py.File(folder / "hdf5.mat", "w", userblock_size=512) as file:
        file.create_group("log").create_dataset("t", data=seconds[None])
        file.create_dataset("u", data=np.sin(seconds)[None], compression="gzip")
    with nptdms.TdmsWriter(folder / "log.tdms") as writer:
        for name in ("u", "x"):
            own = {"wf_increment": 1e-3, "unit_string": "V"}
            writer.write_segment([nptdms.ChannelObject("Rig", name, np.sin(seconds), own)])


def _table(header, columns):
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(zip(*(column.tolist() for column in columns), strict=True))
    return text.getvalue()


def write_results(folder: pathlib.Path) -> None:
    """Write a good file of each kind of results."""
    write_parameters(folder / "parameters.json", complete(estimate()))
    write_tuning(folder / "tuning.json", plain())
    write_codesign(folder / "codesign.json", co_design())


MAPPING = """\
format = 1
[campaign]
name = "rig A"
[[run]]
name = "0001-step"
kind = "torque_step"
pretension = "350 N"
drive_log = "log.csv"
from = "10 ms"
to = "60 ms"
[run.initial]
x_e = "173 mm"
y_e = "0.300 m"
[drive]
separator = ","
[drive.columns]
t = { channel = "time", unit = "s" }
voltage_1 = { channel = "u1", unit = "V", scale = 1.0 }
voltage_2 = { channel = "u2", unit = "V" }
alpha_1 = { channel = "enc1", unit = "deg", sign = -1 }
alpha_2 = { channel = "enc2", unit = "deg", wraps = 360 }
"""

VISION = """\
format = 1
video = "video.avi"
[time]
frame_rate = "30 Hz"
first_frame = "0.05 s"
exposure = "4 ms"
readout = "22 ms"
readout_direction = "down"
stamp_at = "middle row, mid exposure"
[calibration]
photos = "board/*.jpg"
inner_corners = [9, 6]
square = "40 mm"
[colours.green]
hue = ["100 deg", "170 deg"]
saturation = ["45 %", "100 %"]
value = ["12 %", "100 %"]
{marks}{markers}"""
MARK = """\
[[marks]]
name = "mark {x} {y}"
x = "{x} mm"
y = "{y} mm"
z = "0 mm"
colour = "green"
diameter = "44 mm"
near = [154, 962]
"""
MARKER = """\
[[markers]]
body = "end_effector"
x = "{x} mm"
y = "0 mm"
depth = "20 mm"
colour = "green"
diameter = "40 mm"
"""
VISION = VISION.format(
    markers="".join(MARKER.format(x=x) for x in (-110, 110)),
    marks="".join(MARK.format(x=x, y=y) for x in (-45, 2200) for y in (-45, 1150)),
)
