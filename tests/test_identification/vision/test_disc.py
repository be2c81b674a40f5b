import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from identification.vision.spots.disc import LINEAR, Shape, measure

PLATE, COLOUR = np.array([0.018, 0.016, 0.016]), np.array([0.05, 0.33, 0.02])
WALL = np.array([0.38, 0.45, 0.5])
RADIUS, BLUR = 11.0, 0.9
PIECES = (np.arange(9) + 0.5) / 9 - 0.5


def drawn(centre, *, travel=(0.0, 0.0), size=60, wall=None, arm=None):
    """A disc on a dark plate by 81 pieces of each pixel, blurred by its path and the lens."""
    v, u = np.mgrid[:size, :size].astype(float)
    light = np.zeros((size, size, 3)) + PLATE
    if wall is not None:
        light[:, : int(wall)] = WALL
    cover = np.zeros((size, size))
    shares = np.linspace(-0.5, 0.5, 15)
    for share in shares:
        at = np.array(centre) + share * np.array(travel)
        for du in PIECES:
            for dv in PIECES:
                cover += (u + du - at[0]) ** 2 + (v + dv - at[1]) ** 2 < RADIUS**2
    cover = (cover / len(shares) / 81)[..., None]
    light = light + cover * (COLOUR - light)
    if arm is not None:
        light[:, int(arm) :] = WALL
    return stored(blurred(light))


def blurred(light):
    steps = np.arange(-4, 5)
    kernel = np.exp(-0.5 * (steps / BLUR) ** 2)
    kernel /= kernel.sum()
    padded = np.pad(light, ((4, 4), (4, 4), (0, 0)), mode="edge")
    rows = sum(w * padded[k : k + len(light)] for k, w in enumerate(kernel))
    return sum(w * rows[:, k : k + light.shape[1]] for k, w in enumerate(kernel))


def stored(light):
    levels = np.interp(light, LINEAR, np.arange(256))
    return np.round(levels).astype(np.uint8)


def shape(travel=(0.0, 0.0)):
    return Shape(RADIUS * np.eye(2), BLUR, np.array(travel))


inside_pixel = st.floats(-0.5, 0.5)


@hypothesis.settings(max_examples=15)
@hypothesis.given(u=inside_pixel, v=inside_pixel)
def test_a_disc_is_found_to_a_hundredth_of_a_pixel_wherever_its_centre_is(u, v):
    centre = np.array([30 + u, 30 + v])
    disc = measure(drawn(centre), np.array([30.4, 29.5]), shape())
    # Rounding to levels leaves some thousandths, the pieces of a pixel a thousandth.
    assert np.abs(disc.centre - centre).max() < 0.01
    assert disc.hidden < 0.005
    assert disc.scale == pytest.approx(1, abs=0.02)


@hypothesis.settings(max_examples=8)
@hypothesis.given(u=inside_pixel, long=st.floats(2, 14))
def test_a_disc_that_moves_is_found_in_the_middle_of_its_path(u, long):
    centre, travel = np.array([30 + u, 30.2]), (long, -0.3 * long)
    disc = measure(drawn(centre, travel=travel), np.array([30.3, 30.0]), shape(travel))
    assert np.abs(disc.centre - centre).max() < 0.02
    assert disc.hidden < 0.01


def test_a_bright_wall_beside_the_plate_pulls_a_disc_by_less_than_a_fiftieth_of_a_pixel():
    centre = np.array([30.2, 30.1])
    disc = measure(drawn(centre, wall=14), np.array([30.0, 30.0]), shape())
    assert np.abs(disc.centre - centre).max() < 0.02


@pytest.mark.parametrize("arm", [34, 37, 39])
def test_a_disc_behind_an_arm_is_told_by_its_shape(arm):
    disc = measure(drawn(np.array([30.0, 30.0]), arm=arm), np.array([29.5, 30.0]), shape())
    assert disc is None or disc.hidden > 0.02


def test_a_disc_over_the_edge_of_the_picture_is_none():
    assert measure(drawn(np.array([30.0, 30.0])), np.array([8.0, 30.0]), shape()) is None
