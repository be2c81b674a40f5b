import tomllib

import numpy as np
import pytest
from rig_film import shoot, usual

from identification.vision.proposal import propose
from identification.vision.proposal.patches import Disc, clusters
from identification.vision.settings import VisionError, read_vision


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    folder = tmp_path_factory.mktemp("film")
    shoot(usual(6, frames=14, speed=1.5, clutter=0), folder)
    return folder


@pytest.fixture(scope="module")
def proposed(film):
    return propose(film / "video.avi", film / "proposed.toml")


def test_the_marks_are_found_where_they_are_clicked(film, proposed):
    wanted = read_vision(film / "vision.toml").marks
    found = tomllib.loads((film / "proposed.toml").read_text())["marks"]
    near = np.array([mark["near"] for mark in found])
    for mark in wanted:
        # A hand's click is up to 5 px off in each direction.
        assert np.hypot(*(near - np.array(mark.near)).T).min() < 8
    assert proposed.picture.exists()


def test_what_moves_is_a_marker_and_those_of_a_colour_are_on_one_body(film, proposed):
    markers = tomllib.loads((film / "proposed.toml").read_text())["markers"]
    assert [marker["body"] for marker in markers].count("end_effector") == 2
    assert len(markers) == 4


def test_what_no_picture_tells_is_empty_and_asked_for(film, proposed):
    with pytest.raises(VisionError, match="empty, and so are"):
        read_vision(film / "proposed.toml")


def test_a_file_that_may_have_been_filled_in_is_not_overwritten(film, proposed):
    with pytest.raises(ValueError, match="is there already"):
        propose(film / "video.avi", film / "proposed.toml")


def disc(hue):
    return Disc(np.zeros(2), 10.0, hue, 0.8, 0.6)


def test_hues_are_parted_at_their_gaps_also_across_zero():
    found = clusters([disc(h) for h in (355.0, 2.0, 4.0, 120.0, 124.0, 220.0)])
    assert found["red"] == (355.0, 4.0)
    assert found["green"] == (120.0, 124.0)
    assert len(found) == 3
