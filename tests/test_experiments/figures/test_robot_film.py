import re

import numpy as np
import pytest

from experiments.figures.robot_film import Track, robot_film
from experiments.figures.robot_view import cable_loop
from scdpr_jax.robot.prototype import consistent

ROBOT = consistent()
TIME = np.linspace(0, 2, 201)


def track(name="a run"):
    x = 0.6 + 0.3 * TIME
    still = np.zeros_like(TIME)
    return Track(
        name, TIME, np.stack([x, 0.02 * TIME, x + 0.01, x - 0.02, still + 0.5], axis=1)
    )


def matrices(film, identifier):
    rule = re.search(rf"@keyframes {identifier} {{(.*?)\n", film)[1]
    return [
        tuple(map(float, numbers.split(",")))
        for numbers in re.findall(r"matrix\(([^)]+)\)", rule)
    ]


def test_a_film_has_no_script_and_no_address():
    film = str(robot_film(ROBOT, track(), name="film", ghost=track("before")))
    assert "<script" not in film
    assert "http" not in film
    assert "url(" not in film


@pytest.mark.parametrize("path", ["alpha", "beta", "gamma"])
@pytest.mark.parametrize("side", [0, 1])
def test_a_cables_line_begins_and_ends_where_the_cable_does(path, side):
    film = str(robot_film(ROBOT, track(), name="film"))
    first = matrices(film, f"film-{path}{side}")[0]
    begin, end = 1e3 * cable_loop(ROBOT, track().position[0])[path][side]
    height = 1e3 * float(ROBOT.frame.height)
    a, b, _, _, x, y = first
    # Printed to a tenth of a millimetre; two of them in the far end.
    assert (x, y) == pytest.approx((begin[0], height - begin[1]), abs=0.051)
    assert (x + a, y + b) == pytest.approx((end[0], height - end[1]), abs=0.11)


def test_what_is_to_be_seen_is_told_in_numbers():
    film = str(robot_film(ROBOT, track(), name="film"))
    assert "between x 600 and 1200 mm" in film
    assert "tilts by up to 2.3°" in film
    assert "part by up to 30 mm" in film


def test_poses_for_paper_say_when_they_are():
    film = str(robot_film(ROBOT, track(), name="film"))
    assert re.findall(r"<figcaption>t = (\S+) s", film) == ["0.10", "0.60", "1.00", "1.50"]
