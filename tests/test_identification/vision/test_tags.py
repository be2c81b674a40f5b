import cv2
import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from identification.vision.spots.disc import Shape
from identification.vision.spots.tags import Tag, tag_size

SIDE = 60
SHAPE = Shape(SIDE / np.sqrt(2) * np.eye(2), 1.0, np.zeros(2))


def picture(number, corners, size=240):
    """A tag on white whose corners are at four places, each pixel by 36 pieces of it."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    tag = cv2.aruco.generateImageMarker(dictionary, number, 6, borderBits=1) > 128
    flat = np.array([[0, 0], [6, 0], [6, 6], [0, 6]], np.float32)
    turn = cv2.getPerspectiveTransform(np.float32(corners), flat)
    inner = (np.arange(6) + 0.5) / 6 - 0.5
    v, u = np.mgrid[:size, :size].astype(float)
    light = np.zeros((size, size))
    for du in inner:
        for dv in inner:
            at = np.stack([u + du, v + dv, np.ones_like(u)], axis=-1) @ turn.T
            cell = np.floor(at[..., :2] / at[..., 2:]).astype(int)
            on = ((cell >= 0) & (cell < 6)).all(axis=-1)
            held = np.clip(cell, 0, 5)
            light += np.where(on, 40 + 180 * tag[held[..., 1], held[..., 0]], 230)
    return np.repeat((light / 36).astype(np.uint8)[..., None], 3, axis=-1)


def square(centre, angle, tilt=0.0):
    half = SIDE / 2
    flat = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turned = flat @ turn.T
    # As a plane that leans: farther corners are smaller.
    return centre + turned / (1 + tilt * turned[:, :1] / half)


@hypothesis.settings(max_examples=10)
@hypothesis.given(u=st.floats(-0.5, 0.5), v=st.floats(-0.5, 0.5), angle=st.floats(-3, 3))
def test_a_tag_is_found_by_its_number_to_a_tenth_of_a_pixel(u, v, angle):
    centre = np.array([120 + u, 118 + v])
    seen = Tag(7, "4X4_50").at(picture(7, square(centre, angle)), centre + 8, SHAPE, 20.0)
    assert np.hypot(*(seen.centre - centre)) < 0.1


def test_the_centre_of_a_tag_that_leans_is_not_the_mean_of_its_corners():
    centre = np.array([120.0, 120.0])
    corners = square(centre, 0.3, tilt=0.2)
    seen = Tag(3, "4X4_50").at(picture(3, corners), centre, SHAPE, 20.0)
    assert np.hypot(*(seen.centre - centre)) < 0.15
    assert np.hypot(*(corners.mean(axis=0) - centre)) > 0.8


def test_another_number_is_not_taken_for_it():
    shown = picture(7, square(np.array([120.0, 120.0]), 0.0))
    assert Tag(8, "4X4_50").at(shown, np.array([120.0, 120.0]), SHAPE, 20.0) is None
    assert Tag(8, "4X4_50").places(shown, 0.0, np.inf) == []
    assert tag_size("4X4_50", 7, shown) == pytest.approx(SIDE / np.sqrt(2), rel=0.03)


def test_a_dictionary_that_is_none_is_refused_with_those_that_are():
    shown = picture(7, square(np.array([120.0, 120.0]), 0.0))
    with pytest.raises(ValueError, match=r"got '9X9', expected one of .*4X4_50"):
        Tag(7, "9X9").places(shown, 0.0, np.inf)
