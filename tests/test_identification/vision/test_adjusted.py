"""A lens adjusted to marks: what photos of a board leave open, marks tell."""

import dataclasses

import numpy as np
import pytest
from rig_camera import Camera
from rig_video import MARKS

from identification.vision.lens import Lens, View, adjusted, fit_plane

CAMERA = Camera()
PLACES = np.array([[*place, 0.0] for place in MARKS.values()])
GRID = np.array([[x, y, 0.02] for x in (0.3, 1.1, 1.9) for y in (0.2, 0.5, 0.9)])
NO_DISCS = np.zeros(len(PLACES))
# Focal lengths, principal point, k1, k2: what photos of a board leave open of this camera.
OPEN = np.zeros((5, 9))
OPEN[[0, 0, 1, 2, 3, 4], [0, 1, 2, 3, 4, 5]] = 0.3, 0.3, 0.4, 0.4, 8e-4, 8e-4


def seen_by(shares, noise, random):
    """A lens as photos have it, and what the true camera sees of the marks."""
    stated = Lens(CAMERA.matrix, np.array(CAMERA.distortion), 0.1, OPEN)
    true = stated.changed(shares @ OPEN)
    view = View(true, CAMERA.rotation, -CAMERA.rotation @ np.array(CAMERA.position))
    pixels = view.pixels(PLACES) + random.normal(0, noise, (len(PLACES), 2))
    return stated, view, pixels


def fitted(stated, pixels):
    fit = fit_plane(stated, PLACES, pixels, NO_DISCS)
    return fit.view, adjusted(fit, PLACES, pixels, NO_DISCS)


def off(view, true):
    return view.places(true.pixels(GRID), 0.02) - GRID[:, :2]


def test_places_are_several_times_better_than_by_the_boards_lens_alone():
    random = np.random.default_rng(1)
    before, after = [], []
    for _ in range(8):
        stated, true, pixels = seen_by(random.normal(size=5), 5e-3, random)
        alone, better = fitted(stated, pixels)
        before.append(off(alone, true))
        after.append(off(better.marks.view, true))
    assert np.std(after) < 0.5 * np.std(before)


@pytest.mark.parametrize("noise", [5e-3, 0.1])
def test_what_is_left_open_is_as_much_as_places_are_off(noise):
    random = np.random.default_rng(2)
    errors, stated_squares = [], []
    for _ in range(15):
        stated, true, pixels = seen_by(random.normal(size=5), noise, random)
        _, better = fitted(stated, pixels)
        view = better.marks.view
        errors.append(off(view, true))
        moved = [other.places(view.pixels(GRID), 0.02) - GRID[:, :2] for other in better.others]
        stated_squares.append(np.square(moved).sum(axis=0))
    ratio = np.sqrt(np.mean(stated_squares) / np.mean(np.square(errors)))
    # 15 draws of some five numbers that matter, and of each a noise of six residuals.
    assert 0.7 < ratio < 1.5


def test_a_stated_lens_stays_as_it_is():
    random = np.random.default_rng(3)
    stated, _, pixels = seen_by(np.zeros(5), 0.02, random)
    certain = dataclasses.replace(stated, deviations=np.zeros((0, 9)))
    alone, better = fitted(certain, pixels)
    np.testing.assert_array_equal(better.marks.view.lens.matrix, stated.matrix)
    np.testing.assert_allclose(better.marks.view.translation, alone.translation, atol=1e-7)
    assert len(better.others) == 6


def test_marks_that_are_off_leave_the_lens_to_the_board():
    """A tape measure is off by some tenths of a pixel: no lens is learnt from that."""
    random = np.random.default_rng(4)
    stated, _, pixels = seen_by(np.zeros(5), 0.5, random)
    _, better = fitted(stated, pixels)
    change = better.marks.view.lens.matrix - stated.matrix
    assert better.error > 0.1
    assert np.abs(change).max() < 0.4
