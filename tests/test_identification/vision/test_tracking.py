"""Films of a rig with known poses, in half of the usual pixels in each direction."""

import dataclasses
import functools

import numpy as np
import pytest
from rig_film import easy, hard, shoot, usual
from share import share

from identification.vision.settings import read_vision
from identification.vision.tracking import track

KINDS = {"easy": easy, "usual": usual, "hard": hard}
FRAMES = {"easy": 16, "usual": 24, "hard": 34}
MOST = {"easy": (0.20, 0.8), "usual": (0.25, 1.0), "hard": (0.55, 1.9)}
"""Root mean square errors that a camera of twice the pixels is allowed [mm, mrad]."""


@pytest.fixture(scope="module")
def films(tmp_path_factory):
    made = {}

    def film(kind, seed=4):
        if (kind, seed) not in made:
            folder = tmp_path_factory.mktemp(kind)
            shot = KINDS[kind](seed, frames=FRAMES[kind])
            made[kind, seed] = folder, shoot(shot, folder, videos=("avi", "mp4"))
        return made[kind, seed]

    return film


@functools.cache
def tracked(folder, **changes):
    """What a film's video tells; nothing of it changes between tests."""
    vision = read_vision(folder / "vision.toml").model_copy(update=changes)
    return track(vision, folder)


def errors(found, truth):
    return {name: found.poses.values[name] - truth.values[name] for name in truth.values}


def rms(error):
    return float(np.sqrt(np.nanmean(error**2)))


@pytest.mark.parametrize("video", ["video.avi", "video.mp4"])
@pytest.mark.parametrize(
    "kind",
    [
        pytest.param("easy", marks=pytest.mark.slow),
        "usual",
        pytest.param("hard", marks=pytest.mark.slow),
    ],
)
def test_poses_are_as_good_as_a_camera_of_twice_the_pixels_is_asked_for(films, kind, video):
    folder, truth = films(kind)
    error = errors(tracked(folder, video=video), truth)
    place, angle = MOST[kind]
    for name, off in error.items():
        # A codec of few bits costs some more.
        most = (angle if name == "delta_e" else place) * (1.4 if video.endswith("4") else 1)
        assert 1e3 * rms(off) < most, name
        if name != "delta_e":
            assert np.nanmax(np.abs(off)) < 3e-3, name


@pytest.mark.parametrize("kind", [pytest.param("easy", marks=pytest.mark.slow), "usual"])
def test_every_picture_in_which_all_is_seen_gives_every_pose(films, kind):
    folder, truth = films(kind)
    assert tracked(folder).posed >= 0.97 * len(truth.time) - 1


@pytest.mark.slow
def test_hidden_markers_and_copies_have_no_pose_and_most_of_the_rest_have_one(films):
    folder, truth = films("hard")
    found = tracked(folder)
    assert found.doubled.tolist() == truth.again.tolist()
    assert found.dropped == 3
    posed = np.isfinite([*found.poses.values.values()]).all(axis=0)
    seen = (truth.visible > 0.999).all(axis=1) & ~truth.again
    assert not posed[truth.again].any()
    # What is said to be visible keeps 3 px from the arm at any time of the exposure.
    assert not posed[(truth.visible < 0.3).any(axis=1)].any()
    # Beside what is hidden and copied, and where the film ends, too few neighbours tell how
    # fast a marker goes past its row.
    assert posed[seen].sum() >= 0.8 * seen.sum()


@pytest.mark.parametrize("kind", share(("usual", "easy", "hard"), 1))
def test_deviations_are_those_of_the_errors(films, kind):
    folder, truth = films(kind)
    found = tracked(folder)
    error = errors(found, truth)
    places = [name for name in error if name != "delta_e"]
    true = np.sqrt(np.mean([rms(error[name]) ** 2 for name in places]))
    assert 0.6 < found.sigma.position / true < 1.7
    # Of the film with an arm a dozen poses are left.
    most = 2.2 if kind == "hard" else 1.7
    assert 0.6 < found.sigma.angle / rms(error["delta_e"]) < most
    for name, both in found.sigma.columns.items():
        parts = found.sigma.random[name], found.sigma.common[name]
        assert both == pytest.approx(np.hypot(*parts))


def test_a_shake_is_taken_off_and_told(films):
    folder, _ = films("hard")
    found = tracked(folder)
    assert 0.5 < np.sqrt((found.shake**2).sum(axis=1).mean()) < 3
    assert any("shook" in warning for warning in found.warnings)


@pytest.mark.slow
def test_what_is_left_out_costs_what_it_is_there_for(films):
    folder, truth = films("usual")
    vision = read_vision(folder / "vision.toml")
    still = vision.time.model_copy(update={"readout": 0.0})
    no_rows = errors(track(vision.model_copy(update={"time": still}), folder), truth)
    assert rms(no_rows["q_4"]) > 1e-3
    flat = tuple(each.model_copy(update={"depth": 0.0}) for each in vision.markers)
    no_depth = errors(track(vision.model_copy(update={"markers": flat}), folder), truth)
    assert rms(no_depth["q_3"]) > 1e-3
    lens = vision.calibration.model_copy(update={"distortion": []})
    no_lens = track(vision.model_copy(update={"calibration": lens}), folder)
    assert no_lens.marks.rms > 5 * tracked(folder).marks.rms


def test_a_mark_that_is_elsewhere_is_refused_by_its_name(films):
    folder, _ = films("easy")
    vision = read_vision(folder / "vision.toml")
    marks = list(vision.marks)
    marks[2] = marks[2].model_copy(update={"y": marks[2].y + 0.03})
    with pytest.raises(ValueError, match=r"marks: they are .* said to be") as caught:
        track(vision.model_copy(update={"marks": tuple(marks)}), folder)
    assert f": {marks[2].name} " in str(caught.value)


def test_marks_that_are_not_there_are_asked_for(films):
    folder, _ = films("easy")
    vision = read_vision(folder / "vision.toml")
    marks = tuple(each.model_copy(update={"colour": "blue"}) for each in vision.marks)
    with pytest.raises(ValueError, match="fewer than 4 were found whole"):
        track(vision.model_copy(update={"marks": marks}), folder)


def test_a_cut_off_video_is_told_and_a_broken_one_is_one_error(films, tmp_path):
    folder, _ = films("easy")
    whole = (folder / "video.avi").read_bytes()
    short = folder / "short.avi"
    short.write_bytes(whole[: len(whole) // 2])
    assert any("cut off" in warning for warning in tracked(folder, video="short.avi").warnings)
    for content in (b"", whole[:200], b"no video" * 1000):
        (folder / "broken.avi").write_bytes(content)
        with pytest.raises(ValueError, match=r"broken\.avi: the video can't be read"):
            tracked(folder, video="broken.avi")
    with pytest.raises(ValueError, match=r"nothing\.avi: no such video"):
        tracked(folder, video="nothing.avi")


def test_pictures_are_told_apart_by_nothing_but_the_film(films):
    """The same film gives the same poses."""
    folder, _ = films("easy")
    first, second = tracked(folder), tracked.__wrapped__(folder)
    for name, values in first.poses.values.items():
        np.testing.assert_array_equal(values, second.poses.values[name])
    assert dataclasses.astuple(first.sigma)[0] == dataclasses.astuple(second.sigma)[0]
