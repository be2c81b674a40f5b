import dataclasses
import pathlib
import tomllib

import knock_recording
import log_styles
import numpy as np
import pytest
from share import share

from identification.bring.campaign_import import import_campaign
from identification.bring.proposal.propose import propose_mapping
from identification.campaign import CampaignError, read_campaign
from identification.knocks.frequency_map import frequency_map

SHARED = pathlib.Path(__file__).parents[4] / "shared" / "data" / "campaigns" / "rig-a"
ANSWERS = {
    'pretension = ""': 'pretension = "350 N"',
    'counts_per_rev = ""': "counts_per_rev = 26624",
    'clock_offset = "unknown"': 'clock_offset = "0 s"',
}
"""What no log says: three lines at most."""
HEIGHT = 1.112
"""Of the frame [m], as the robot states it where nobody does."""
SOME = (0, 2, 4, 6, 10, 12)
"""Runs of every kind."""


def proposed(folder, files):
    """The campaign of a proposal in which a person has corrected three lines at most."""
    propose_mapping(files, folder / "m.toml")
    text = (folder / "m.toml").read_text(encoding="utf-8")
    for left_empty, answer in ANSWERS.items():
        text = text.replace(left_empty, answer, 1)
    (folder / "m.toml").write_text(text, encoding="utf-8")
    import_campaign(folder / "m.toml", folder / "out")
    return read_campaign(folder / "out")


def lossy(run, random):
    """A run whose camera loses markers now and then."""
    if run.camera is None:
        return run
    position = run.camera.position.copy()
    position[random.random(len(position)) < 0.03] = np.nan
    return dataclasses.replace(run, camera=dataclasses.replace(run.camera, position=position))


@pytest.mark.skipif(not SHARED.exists(), reason="the shared campaigns aren't there")
@pytest.mark.parametrize("kind", share(log_styles.STYLES[::2] + log_styles.STYLES[1::2], 4))
def test_a_campaign_of_any_style_is_proposed_as_it_was(kind, tmp_path):
    random = np.random.default_rng([8, log_styles.STYLES.index(kind)])
    style, campaign = log_styles.draw_style(kind, random), read_campaign(SHARED)
    runs = tuple(lossy(campaign.runs[k], random) for k in SOME)
    campaign = dataclasses.replace(campaign, runs=runs)
    counts = campaign.counts_per_rev
    files = [
        log
        for k, run in enumerate(campaign.runs)
        for log in log_styles.write_run(tmp_path, run, style, random, counts, f"log{k:03d}")
    ]
    found = proposed(tmp_path, files)
    assert [run.kind for run in found.runs] == [run.kind for run in campaign.runs]
    names = {a.name: b.name for a, b in zip(found.runs, campaign.runs, strict=True)}
    renamed = tuple(dataclasses.replace(run, name=names[run.name]) for run in found.runs)
    worst = log_styles.differences(campaign, dataclasses.replace(found, runs=renamed))
    # Tens of radians and metres through two changes of unit: a few roundings.
    assert max(worst.values()) < 1e-12


def slipped(run, slip):
    """A run as it was logged with a slip of the lab's."""
    drive, camera = run.drive, run.camera
    if slip == "motors exchanged":
        drive = dataclasses.replace(
            drive, voltage=drive.voltage[:, ::-1], angle=drive.angle[:, ::-1]
        )
    elif slip == "encoder reversed":
        drive = dataclasses.replace(drive, angle=drive.angle * [-1, 1])
    elif camera is not None:
        position = camera.position.copy()
        position[:, 4] = HEIGHT - position[:, 4]
        camera = dataclasses.replace(camera, position=position)
    return dataclasses.replace(run, drive=drive, camera=camera)


@pytest.mark.skipif(not SHARED.exists(), reason="the shared campaigns aren't there")
@pytest.mark.parametrize(
    "slip",
    [
        "motors exchanged",
        pytest.param("encoder reversed", marks=pytest.mark.slow),
        pytest.param("y downwards", marks=pytest.mark.slow),
    ],
)
def test_slips_of_plugs_and_signs_are_put_right_in_the_mapping(slip, tmp_path):
    random = np.random.default_rng(len(slip))
    style, campaign = log_styles.draw_style("utf-16", random), read_campaign(SHARED)
    campaign = campaign.with_runs([campaign.runs[k].name for k in SOME])
    counts = campaign.counts_per_rev
    files = [
        log
        for k, run in enumerate(slipped(run, slip) for run in campaign.runs)
        for log in log_styles.write_run(tmp_path, run, style, random, counts, f"log{k:03d}")
    ]
    found = proposed(tmp_path, files)
    names = {a.name: b.name for a, b in zip(found.runs, campaign.runs, strict=True)}
    renamed = tuple(dataclasses.replace(run, name=names[run.name]) for run in found.runs)
    worst = log_styles.differences(campaign, dataclasses.replace(found, runs=renamed))
    assert max(worst.values()) < 1e-12


def test_frames_in_the_drives_own_log_are_frames(tmp_path):
    made = knock_recording.recording(9, knocks=2)
    drive, camera = made.whole.drive, made.whole.camera
    rows = dict(zip(np.searchsorted(drive.time, camera.time).tolist(), camera.position.tolist(),
                    strict=True))  # fmt: skip
    frame, lines = [""] * 5, []
    for k, time in enumerate(drive.time):
        frame = [repr(cell) for cell in rows[k]] if k in rows else frame
        own = [repr(float(each)) for each in (time, *drive.voltage[k], *drive.angle[k])]
        lines.append(";".join([*own, *frame]))
    header = (
        "t [s];u1 [V];u2 [V];enc1 [rad];enc2 [rad];x_e [m];delta_e [rad];q3 [m];q4 [m];y_e [m]"
    )
    (tmp_path / "all.csv").write_text("\n".join([header, *lines]) + "\n")
    found = proposed(tmp_path, [tmp_path / "all.csv"])
    frames = sum(len(run.camera.time) for run in found.runs)
    assert abs(frames - len(camera.time)) <= 2
    np.testing.assert_array_equal(found.runs[0].camera.position[0], camera.position[0])


@pytest.mark.slow
def test_many_knocks_in_one_recording_are_as_many_runs_with_the_same_frequencies(tmp_path):
    made, random = knock_recording.recording(6, knocks=8), np.random.default_rng(6)
    style = log_styles.draw_style("utf-16", random)
    counts = knock_recording.COUNTS
    files = log_styles.write_run(tmp_path, made.whole, style, random, counts, "all")
    found = proposed(tmp_path, files)
    assert [run.kind for run in found.runs] == ["pseudo_impulse"] * 8
    alone, cut = frequency_map(made.single), frequency_map(found)
    assert len(alone.runs) == len(cut.runs) == 8
    sigma = np.hypot(alone.frequency_sigma, cut.frequency_sigma)
    assert np.all(np.abs(alone.frequency - cut.frequency) < sigma)


def test_what_no_log_says_is_left_empty_and_refused(tmp_path):
    made, random = knock_recording.recording(7, knocks=2), np.random.default_rng(7)
    style = log_styles.draw_style("semicolons", random)
    files = log_styles.write_run(tmp_path, made.whole, style, random, 26624.0, "all")
    propose_mapping(files, tmp_path / "m.toml")
    assert tomllib.loads((tmp_path / "m.toml").read_text())["defaults"]["pretension"] == ""
    with pytest.raises(CampaignError, match=r"pretension.*left empty"):
        import_campaign(tmp_path / "m.toml", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_every_column_has_a_reason(tmp_path):
    made, random = knock_recording.recording(7, knocks=2), np.random.default_rng(7)
    style = log_styles.draw_style("mat 7.3", random)
    files = log_styles.write_run(tmp_path, made.whole, style, random, 26624.0, "all")
    propose_mapping(files, tmp_path / "m.toml")
    text = (tmp_path / "m.toml").read_text()
    names = {*log_styles.DRIVE, *log_styles.CAMERA, "t"}
    assert all(f"# {name}: " in text for name in names)


def test_logs_without_a_drive_are_refused(tmp_path):
    (tmp_path / "pose.csv").write_text("a,b\n1,2\n2,3\n3,4\n")
    with pytest.raises(CampaignError, match="no log has commands and encoders"):
        propose_mapping([tmp_path / "pose.csv"], tmp_path / "m.toml")
    assert not (tmp_path / "m.toml").exists()
