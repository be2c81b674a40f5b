"""Frequency maps of campaigns, and their file."""

import pathlib

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg

from identification.campaign.read import read_campaign
from identification.campaign.types import CameraStream, Campaign, DriveStream, Knock, Run
from identification.knocks.frequency_map import (
    FrequencyMap,
    frequency_map,
    read_frequencies,
    write_frequencies,
)
from scdpr_jax.provenance import Provenance
from scdpr_jax.robot.cable import potential
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace

CAMPAIGNS = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "campaigns"
HEADER = (
    "x [m],y [m],pretension [N],frequency [Hz],frequency_sigma [Hz],damping_ratio [1],"
    "damping_ratio_sigma [1],run"
)


def run(name, *, frequency=3.0, amplitude=5e-3, clock_offset=0.0, **changes):
    time = np.arange(0.01, 3.0, 1 / 30)
    random = np.random.default_rng(1)
    position = np.zeros((len(time), 5))
    x, t = np.full_like(time, 0.8), np.maximum(time - 0.3 - (clock_offset or 0.0), 0.0)
    x = x + amplitude * np.exp(-0.2 * t) * np.sin(2 * np.pi * frequency * t)
    position[:, 0] = x + 0.19e-3 * random.normal(size=len(time))
    position[:, 4] = 0.5
    drive = DriveStream(
        time=np.array([0.0, 3.0]), voltage=np.zeros((2, 2)), angle=np.zeros((2, 2))
    )
    fields = {
        "name": name,
        "kind": "pseudo_impulse",
        "pretension": 350.0,
        "pretension_label": "350 N",
        "drive": drive,
        "camera": CameraStream(time=time, position=position),
        "knock": Knock(start=0.3, duration=0.03),
        "clock_offset": clock_offset,
    }
    return Run(**{**fields, **changes})


def test_every_knock_is_a_row_with_its_pose_and_pretension():
    campaign = Campaign(
        name="c",
        runs=(run("a", frequency=2.5), run("b", kind="free"), run("c", frequency=4.0)),
    )
    found = frequency_map(campaign)
    assert found.runs == ("a", "c")
    # The median of nine camera samples before the knock.
    np.testing.assert_allclose(found.x, 0.8, atol=3 * 0.19e-3)
    np.testing.assert_array_equal(found.y, [0.5, 0.5])
    np.testing.assert_array_equal(found.pretension, [350.0, 350.0])
    assert np.all(np.abs(found.frequency - [2.5, 4.0]) < 4 * found.frequency_sigma)
    assert found.unresolved == ()


@pytest.mark.parametrize("clock_offset", [0.2, None])
def test_the_cameras_clock_is_allowed_for(clock_offset):
    found = frequency_map(Campaign(name="c", runs=(run("a", clock_offset=clock_offset),)))
    assert abs(found.frequency[0] - 3.0) < 4 * found.frequency_sigma[0]


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"amplitude": 0.0}, "rang less than"),
        ({"camera": None}, "no camera.csv"),
        ({"knock": None}, r"no \[knock\]"),
        ({"knock": Knock(start=0.0, duration=0.03)}, "saw no pose before"),
    ],
)
def test_a_knock_that_gives_no_frequency_is_listed_with_the_reason(changes, reason):
    campaign = Campaign(name="c", runs=(run("good"), run("bad", **changes)))
    found = frequency_map(campaign)
    assert found.runs == ("good",)
    assert [name for name, _ in found.unresolved] == ["bad"]
    with pytest.raises(
        ValueError, match=f"none of 1 pseudo_impulse runs(.|\n)*bad: .*{reason}"
    ):
        frequency_map(Campaign(name="c", runs=(run("bad", **changes),)))


def a_map():
    return FrequencyMap(
        x=np.array([0.1, 1.0 / 3.0]),
        y=np.array([0.5, 0.25]),
        pretension=np.array([200.0, 350.0]),
        frequency=np.array([2.4, 3.9]),
        frequency_sigma=np.array([1e-3, 2e-3]),
        damping_ratio=np.array([0.0, 0.01]),
        damping_ratio_sigma=np.array([1e-4, 1e-3]),
        fft_frequency=np.array([2.41, 3.88]),
        residuals_are_noise=np.array([True, False]),
        runs=("0001-knock", "0002, a second"),
    )


def test_a_map_is_read_as_it_was_written(tmp_path):
    path = tmp_path / "frequencies.csv"
    write_frequencies(a_map(), path)
    assert path.read_text().splitlines()[0] == HEADER
    back = read_frequencies(path)
    for name in ("x", "y", "pretension", "frequency", "frequency_sigma", "damping_ratio"):
        np.testing.assert_array_equal(getattr(back, name), getattr(a_map(), name))
    assert back.runs == a_map().runs
    assert np.all(np.isnan(back.fft_frequency))


def test_a_row_says_where_it_comes_from(tmp_path):
    path = tmp_path / "frequencies.csv"
    made = Provenance(campaign="=rig", source="0123abcd", date="2026-11-30", version="1")
    write_frequencies(a_map(), path, provenance=made)
    header, *rows = path.read_text().splitlines()
    assert header == f"{HEADER},campaign,source,date,version"
    assert all(row.endswith(",'=rig,0123abcd,2026-11-30,1") for row in rows)
    np.testing.assert_array_equal(read_frequencies(path).frequency, a_map().frequency)


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "frequencies.csv"
    path.write_text("old")

    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr("os.replace", fail)
    with pytest.raises(OSError, match="disk full"):
        write_frequencies(a_map(), path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["frequencies.csv"]
    assert path.read_text() == "old"


ROW = "0.1,0.5,350,3.1,0.001,0.01,0.001,0007"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"row 1: .*missing or twice: x \[m\]"),
        (HEADER, "no row under the header"),
        (HEADER.replace("[Hz]", "[rad/s]") + "\n" + ROW, r"missing or twice: frequency \[Hz\]"),
        (HEADER + "\n" + ROW + "\n\n" + ROW + ",1", "row 4: 9 cells, expected 8"),
        (
            HEADER + "\n" + ROW.replace("3.1", "-3.1"),
            r"row 2, column 'frequency \[Hz\]': got '-3.1'",
        ),
        (
            HEADER + "\n" + ROW.replace("0.01,", "-1,"),
            r"column 'damping_ratio \[1\]': got '-1'",
        ),
        (HEADER + "\n" + ROW.replace("350", "nan"), r"column 'pretension \[N\]': got 'nan'"),
        (HEADER + "\n" + ROW.replace("0.5", ""), r"column 'y \[m\]': got ''"),
    ],
)
def test_a_bad_file_is_refused_with_the_place(tmp_path, text, message):
    path = tmp_path / "frequencies.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=message) as caught:
        read_frequencies(path)
    assert str(path) in str(caught.value)


@jax.jit
def stiffness_of(robot, pose):
    return jax.hessian(lambda q: potential(robot, q))(pose)


def held_frequency(run):
    """First natural frequency [Hz] of rig A's end-effector between held carriages."""
    robot = replace(consistent(), {"effective_pretension": 85.166460})
    pose = np.nanmean(run.camera.position[run.camera.time > 2.0], axis=0)
    pose[1] = 0.0
    stiffness = np.asarray(stiffness_of(robot, jnp.asarray(pose)))
    mass = np.diag([float(robot.end_effector.mass), float(robot.end_effector.inertia)])
    return np.sqrt(scipy.linalg.eigvalsh(stiffness[:2, :2], mass)[0]) / (2 * np.pi)


@pytest.mark.skipif(not CAMPAIGNS.exists(), reason="the shared campaigns aren't shipped")
def test_rig_a_rings_at_the_frequency_of_held_carriages():
    campaign = read_campaign(CAMPAIGNS / "rig-a")
    found = frequency_map(campaign)
    held = np.array([held_frequency(campaign.run(name)) for name in found.runs])
    # Three standard errors, and 0.05 % for amplitudes of 12 mm on cables of 0.4 m: the
    # restoring force falls off by (12/400)²/2 of itself.
    tolerance = 3 * found.frequency_sigma + 5e-4 * held
    assert np.all(np.abs(found.frequency - held) < tolerance)
    # In the last one the lower carriage slides to the end of the record.
    np.testing.assert_array_equal(found.residuals_are_noise, [True, True, True, False])


@pytest.mark.skipif(not CAMPAIGNS.exists(), reason="the shared campaigns aren't shipped")
def test_all_knocks_of_rig_b_are_resolved():
    found = frequency_map(read_campaign(CAMPAIGNS / "rig-b"))
    assert len(found.runs) == 4
    assert found.unresolved == ()
    # A hundredth of the frequency is what a shaper's choice begins to notice.
    assert np.all(found.frequency_sigma < 0.01 * found.frequency)
    # Peak picking is good to a tenth of its resolution of 0.4 to 0.6 Hz.
    assert np.all(np.abs(found.fft_frequency - found.frequency) < 0.06)


@pytest.mark.parametrize(("count", "lines"), [(1, 2), (8, 9), (9, 10), (400, 10)])
def test_a_map_tells_its_knocks_in_a_few_lines(count, lines):
    row = np.full(count, 3.0)
    shown = FrequencyMap(
        x=row,
        y=row,
        pretension=350 / 3 * row,
        frequency=row,
        frequency_sigma=row / 300,
        damping_ratio=row,
        damping_ratio_sigma=row,
        fft_frequency=row,
        residuals_are_noise=row > 0,
        runs=("0001-pseudo-impulse",) * count,
    )
    text = repr(shown).splitlines()
    assert text[0] == f"FrequencyMap of {count} knocks: 3 to 3 Hz, 0 unresolved"
    assert text[1] == "  3 ± 0.01 Hz at (3.00 m, 3.00 m), 350 N: 0001-pseudo-impulse"
    assert len(text) == lines
