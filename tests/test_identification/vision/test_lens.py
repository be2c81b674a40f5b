import dataclasses

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st
from rig_camera import Camera
from rig_film import photograph
from rig_video import MARKS

from identification.vision.lens import Lens, View, calibrate, fit_plane

CAMERA = Camera()
LENS = Lens(CAMERA.matrix, np.array(CAMERA.distortion))
VIEW = View(LENS, CAMERA.rotation, -CAMERA.rotation @ np.array(CAMERA.position))
PLACES = np.array([[*place, 0.0] for place in MARKS.values()])
NO_DISCS = np.zeros(len(PLACES))


@pytest.fixture(scope="module")
def photos(tmp_path_factory):
    folder = tmp_path_factory.mktemp("board")
    photograph(CAMERA, folder, 8, np.random.default_rng(5))
    return sorted(folder.glob("*.jpg"))


def calibrated(photos, **changes):
    told = {"inner_corners": (9, 6), "square": 0.04, "size": CAMERA.size, **changes}
    return calibrate(photos, **told)


@hypothesis.given(x=st.floats(0, 2.2), y=st.floats(-0.1, 1.2), depth=st.floats(-0.1, 0.3))
def test_what_a_place_is_seen_as_sees_the_place(x, y, depth):
    pixels = VIEW.pixels(np.array([[x, y, depth]]))
    # A tenth of a micrometre: the distortion's inverse is iterated to 1e-11.
    np.testing.assert_allclose(VIEW.places(pixels, depth)[0], [x, y], atol=1e-7)


def test_the_camera_is_found_by_six_marks_though_they_lie_in_a_plane():
    found = fit_plane(LENS, PLACES, VIEW.pixels(PLACES), NO_DISCS)
    assert found.rms < 1e-4
    np.testing.assert_allclose(found.view.translation, VIEW.translation, atol=1e-5)


def test_one_mark_that_is_off_by_five_pixels_moves_the_rest_by_less_than_one():
    seen = VIEW.pixels(PLACES)
    seen[2] += [5.0, 0.0]
    found = fit_plane(LENS, PLACES, seen, NO_DISCS)
    off = np.hypot(*found.residual.T)
    assert np.argmax(off) == 2
    assert np.delete(off, 2).max() < 1


def test_the_centroid_of_a_disc_is_beside_its_centre_as_pieces_of_it_say():
    random = np.random.default_rng(1)
    radius = 0.05
    angle, far = random.uniform(0, 2 * np.pi, 200_000), np.sqrt(random.uniform(0, 1, 200_000))
    disc = radius * far[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    place = np.array([2.2, 1.1, 0.0])
    tilted = View(LENS, CAMERA.rotation, VIEW.translation)
    pieces = place + np.concatenate([disc, np.zeros((len(disc), 1))], axis=-1)
    seen = tilted.pixels(pieces)
    # Pieces are weighted by the area that they are seen as.
    step = 1e-5
    along_x = tilted.pixels(pieces + np.array([step, 0, 0])) - seen
    along_y = tilted.pixels(pieces + np.array([0, step, 0])) - seen
    weight = np.abs(along_x[:, 0] * along_y[:, 1] - along_x[:, 1] * along_y[:, 0])
    centroid = (seen * weight[:, None]).sum(axis=0) / weight.sum()
    offset = tilted.centroid_offset(place[None], radius)[0]
    # 200 000 pieces leave 0.02 px of a disc of 28 px across, 32 corners a thousandth.
    np.testing.assert_allclose(offset, centroid - tilted.pixels(place), atol=0.05)


def test_a_lens_is_told_by_photos_of_a_board_within_its_own_deviations(photos):
    lens, notes = calibrated(photos)
    assert lens.rms < 0.1
    assert not notes
    view = dataclasses.replace(VIEW, lens=lens)
    centre = fit_plane(lens, PLACES, VIEW.pixels(PLACES), NO_DISCS).view
    grid = np.array([[x, y, 0.02] for x in (0.3, 1.1, 1.9) for y in (0.2, 0.9)])
    off = centre.places(VIEW.pixels(grid), 0.02) - grid[:, :2]
    # A quarter of a pixel of this camera, of 1.9 mm in half of the pixels of the usual.
    assert np.abs(off).max() < 0.5e-3
    assert view.lens is lens
    assert lens.deviations.shape == (len(photos), 9)


def test_a_board_with_another_number_of_corners_is_refused(photos):
    with pytest.raises(ValueError, match="0 of 8 photos show a board of 7 x 5 inner corners"):
        calibrated(photos, inner_corners=(7, 5))


def test_photos_of_another_size_are_refused(photos):
    with pytest.raises(ValueError, match=r"816 x 612 px, expected 1632 x 1224 as the video"):
        calibrated(photos, size=(1632, 1224))


def test_photos_by_different_lenses_are_refused(photos, tmp_path):
    other = dataclasses.replace(CAMERA, distortion=(0.1, -0.1, 0.0, 0.0, 0.0))
    photograph(other, tmp_path, 4, np.random.default_rng(6))
    with pytest.raises(ValueError, match=r"corners are .* px from the fit"):
        calibrated([*photos[:4], *sorted(tmp_path.glob("*.jpg"))])


def test_one_photo_that_is_none_of_the_lens_is_left_out_and_named(photos, tmp_path):
    other = dataclasses.replace(CAMERA, distortion=(0.1, -0.1, 0.0, 0.0, 0.0))
    photograph(other, tmp_path, 1, np.random.default_rng(6))
    (strange,) = tmp_path.glob("*.jpg")
    renamed = strange.rename(tmp_path / "strange.jpg")
    lens, notes = calibrated([*photos[:7], renamed])
    assert lens.rms < 0.1
    assert notes == ("corners that aren't where the others have them in strange.jpg: not used",)


def test_a_file_that_is_no_picture_is_named(tmp_path):
    (tmp_path / "00.jpg").write_bytes(b"no picture")
    with pytest.raises(ValueError, match=r"00\.jpg is no picture that can be read"):
        calibrated([tmp_path / "00.jpg"])
