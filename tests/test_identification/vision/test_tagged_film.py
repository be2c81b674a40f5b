"""A film in which marks and markers are printed tags, as a newcomer makes them."""

import tomllib

import cv2
import numpy as np
import pytest
from rig_camera import Camera, Sight
from rig_film import document
from rig_pictures import developed, jpeg, write_avi
from rig_video import MARKERS, MARKS, Film, marker_places

from identification.vision.proposal import propose
from identification.vision.settings import VisionError, read_vision
from identification.vision.tracking import track

CAMERA = Camera(readout=0.0, lateral=0.0, exposure=0.0, field_of_view=72.0, pan=0.0)
FILM = Film(camera=CAMERA, frames=8)
SIDE = 0.12


def pose(t):
    return {
        "x_e": 0.8 + 1.5 * t,
        "y_e": 0.5 + 0.1 * t,
        "delta_e": 0.05 - 0.2 * t,
        "q_3": 0.78 + 1.5 * t,
        "q_4": 0.81 + 1.5 * t,
    }


def drawn(sight, light, number, centre, depth, angle):
    """A tag with a white rim, by 16 pieces of each pixel."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    cells = cv2.aruco.generateImageMarker(dictionary, number, 6, borderBits=1) > 128
    corners = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]]) * SIDE + centre
    seen = CAMERA.pixels(np.concatenate([corners, np.full((4, 1), depth)], axis=-1))
    rows, columns = sight.window(seen.min(axis=0) - 2, seen.max(axis=0) + 2)
    at = sight.places(rows, columns, depth, np.zeros(2)) - centre
    x = np.cos(angle) * at[..., 0] + np.sin(angle) * at[..., 1]
    y = -np.sin(angle) * at[..., 0] + np.cos(angle) * at[..., 1]
    cell = np.floor(np.stack([x, -y], axis=-1) / SIDE * 6 + 3).astype(int)
    on = ((cell >= 0) & (cell < 6)).all(axis=-1)
    rim = (np.abs(x) < 0.75 * SIDE) & (np.abs(y) < 0.75 * SIDE)
    held = np.clip(cell, 0, 5)
    shade = np.where(on, np.where(cells[held[..., 1], held[..., 0]], 0.7, 0.02), 0.7)
    patch = light[rows, columns]
    cover = rim.mean(axis=-1)[..., None]
    patch += (
        cover * ((shade * rim).sum(-1) / np.maximum(rim.sum(-1), 1))[..., None] - cover * patch
    )


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tags")
    sight, random = Sight(CAMERA), np.random.default_rng(1)
    times = 0.05 + np.arange(FILM.frames) / FILM.rate
    stored = []
    for t in times:
        light = np.full((*CAMERA.size[::-1], 3), 0.35)
        for number, place in enumerate(MARKS.values()):
            drawn(sight, light, number, np.array(place), 0.0, 0.0)
        now = pose(np.array(t))
        places = marker_places(now)
        for k, (body, *_) in enumerate(MARKERS):
            turn = float(now["delta_e"]) if body == "end_effector" else 0.0
            drawn(sight, light, 10 + k, places[k], 0.02, turn)
        stored.append(jpeg(developed(CAMERA, light, random), 90))
    write_avi(folder / "video.avi", stored, CAMERA.size, FILM.rate)
    (folder / "vision.toml").write_text(
        tagged(document(FILM, random, boards=False, stamped=False))
    )
    return folder, pose(times)


def tagged(text):
    """A film's document with tags in place of discs, and no clicks."""
    parts = text.split("\n[[")
    lines = [parts[0].replace("[time]", 'dictionary = "4X4_50"\n[time]')]
    marks = 0
    markers = 10
    for part in parts[1:]:
        kept = [
            line
            for line in part.splitlines()
            if not line.startswith(("colour", "diameter", "near"))
        ]
        if part.startswith("marks]]"):
            kept.append(f"aruco = {marks}")
            marks += 1
        else:
            kept.append(f"aruco = {markers}")
            markers += 1
        lines.append("[[" + "\n".join(kept) + "\n")
    return "\n".join(lines)


def test_tags_give_poses_to_a_millimetre_without_a_click(film):
    folder, truth = film
    found = track(read_vision(folder / "vision.toml"), folder)
    # Cells of five pixels: one tag in twenty isn't read.
    assert found.posed >= FILM.frames - 2
    assert found.marks.rms < 0.3
    for name, values in truth.items():
        # Tags of 33 px are found to a fifth of a pixel of 3.6 mm.
        most = 6e-3 if name == "delta_e" else 1e-3
        assert np.sqrt(np.nanmean((found.poses.values[name] - values) ** 2)) < most, name


@pytest.fixture(scope="module")
def proposed(film):
    folder, _ = film
    propose(folder / "video.avi", folder / "proposed.toml")
    return tomllib.loads((folder / "proposed.toml").read_text())


def test_tags_are_proposed_with_their_dictionary_and_numbers(proposed):
    assert proposed["dictionary"] == "4X4_50"
    assert {mark["aruco"] for mark in proposed["marks"]} == set(range(len(MARKS)))
    assert {marker["aruco"] for marker in proposed["markers"]} == {10, 11, 12, 13}


def test_tags_that_keep_their_distance_are_on_one_body(proposed):
    bodies = {marker["aruco"]: marker["body"] for marker in proposed["markers"]}
    assert bodies[10] == bodies[11] == "end_effector"


def test_what_is_left_empty_is_asked_for_and_nothing_else(film, proposed):
    folder, _ = film
    with pytest.raises(VisionError, match="empty, and so are") as caught:
        read_vision(folder / "proposed.toml")
    assert "aruco" not in str(caught.value)
