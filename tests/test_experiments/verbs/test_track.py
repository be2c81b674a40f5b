import json
import sys
import tomllib

import numpy as np
import pytest
from rig_film import easy, shoot

from experiments.cli import main
from experiments.verbs.exit_status import BAD_INPUT, DONE, FELL_SHORT
from identification.campaign.quantities import parse_quantity
from identification.campaign.streams import read_camera


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    folder = tmp_path_factory.mktemp("film")
    # Resting but for its end, so that what a run reads is known to the last picture.
    return folder, shoot(easy(8, frames=12), folder, boards=8)


@pytest.fixture(scope="module")
def run(film, tmp_path_factory):
    folder, _ = film
    place = tmp_path_factory.mktemp("campaign") / "0001-torque-step"
    (place.parent / "campaign.toml").write_text("format = 1  # our rig\n")
    status = main(
        [
            "track",
            str(folder / "vision.toml"),
            *("--out", str(place / "camera.csv")),
            *("--json", str(place / "track.json")),
            *("--overlay", str(place / "seen.mp4")),
        ]
    )
    return place, status


def test_a_video_becomes_the_camera_stream_of_a_run(film, run):
    place, status = run
    _, truth = film
    assert status == DONE
    camera, faults = read_camera(place)
    assert not faults
    x_e, delta_e, q_3, q_4, y_e = camera.position.T
    np.testing.assert_allclose(camera.time, truth.time, atol=1e-3)
    for name, values in {"x_e": x_e, "y_e": y_e, "q_3": q_3, "q_4": q_4}.items():
        np.testing.assert_allclose(values, truth.values[name], atol=1e-3)
    np.testing.assert_allclose(delta_e, truth.values["delta_e"], atol=4e-3)


def test_the_summary_says_what_is_pinned(run):
    place, _ = run
    told = json.loads((place / "track.json").read_text())
    assert told["format"] == 1
    assert (told["frames"], told["dropped"], told["doubled"]) == (12, 0, 0)
    assert told["calibration_rms_px"] < 0.3
    assert told["marks_rms_px"] < 1
    assert set(told["sigma"]) == {"x_e", "y_e", "delta_e", "q_3", "q_4"}
    assert told["sigma"]["x_e"].endswith(" mm")
    assert told["sigma"]["delta_e"].endswith(" mrad")
    assert told["warnings"] == []


def test_a_runs_campaign_states_its_camera_and_keeps_its_own_words(run):
    place, _ = run
    text = (place.parent / "campaign.toml").read_text()
    told = json.loads((place / "track.json").read_text())
    assert text.startswith("format = 1  # our rig\n")
    own = tomllib.loads(text)["sensors"]["runs"]["0001-torque-step"]
    wanted = told["sigma"] | {"y_e_offset": told["sigma_common"]["y_e"]}
    assert set(own) == set(wanted)
    for name, value in own.items():
        unit = "rad" if name == "delta_e" else "m"
        written = (parse_quantity(each, unit=unit) for each in (value, wanted[name]))
        assert next(written) == pytest.approx(next(written))


def test_the_overlay_is_a_video_of_as_many_pictures(run):
    from identification.vision.pictures.stream import pictures

    place, _ = run
    with pictures(place / "seen.mp4") as video:
        assert sum(1 for _ in video.frames) == 12


@pytest.mark.slow
def test_its_end_says_where_the_deviations_go(film, tmp_path, capsys):
    folder, _ = film
    assert (
        main(["track", str(folder / "vision.toml"), "--out", str(tmp_path / "c.csv")]) == DONE
    )
    said = capsys.readouterr().out
    assert "in campaign.toml" in said
    assert f"[sensors.runs.{tmp_path.name}]" in said
    assert 'x_e = "' in said
    assert "12 pictures, 12 with every pose" in said


@pytest.mark.slow
def test_markers_that_are_not_seen_leave_empty_cells_and_fall_short(film, tmp_path, capsys):
    folder, _ = film
    text = (folder / "vision.toml").read_text()
    other = text.replace('colour = "red"', 'colour = "magenta"')
    (folder / "other.toml").write_text(
        other + '[colours.magenta]\nhue = ["285 deg", "330 deg"]\nvalue = ["90 %", "100 %"]\n'
    )
    status = main(["track", str(folder / "other.toml"), "--out", str(tmp_path / "camera.csv")])
    assert status == FELL_SHORT
    assert "--overlay" in capsys.readouterr().out
    camera, faults = read_camera(tmp_path)
    assert not faults
    assert np.isnan(camera.position[:, 3]).all()
    assert np.isfinite(camera.position[:, 0]).all()


def test_what_is_missing_is_named_with_its_remedy(film, tmp_path, capsys, monkeypatch):
    folder, _ = film
    assert main(["track", str(folder / "vision.toml")]) == BAD_INPUT
    assert "`--out` is missing" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "cv2", None)
    out = str(tmp_path / "camera.csv")
    assert main(["track", str(folder / "vision.toml"), "--out", out]) == BAD_INPUT
    assert "pip install 'scdpr-jax[video]'" in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "camera.csv").exists()
