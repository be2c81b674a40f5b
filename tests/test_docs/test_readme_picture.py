"""The README's picture is the one that its script makes."""

import re
import xml.etree.ElementTree as ET

import jax.numpy as jnp
import numpy as np
import pages
import pytest

from scdpr_jax.legs.leg import Leg
from scdpr_jax.legs.measures import LegMeasures
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.state import State

PICTURE = pages.ROOT / "docs/robot.svg"
LARGEST = 200_000
"""Bytes that a repository's page can be asked to load."""
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")


@pytest.fixture(scope="module")
def committed():
    return PICTURE.read_text(encoding="utf-8")


def shape(svg):
    """A drawing without its numbers."""
    return _NUMBER.sub("0", svg)


@pytest.fixture(scope="module")
def script():
    return pages.script_of("readme_picture")


def run(script, *, swing):
    """A leg to the picture's target that swings once it is there, as nobody simulated it."""
    time = np.arange(0, 4, 0.01)
    (first, height), (last, _) = script.START, script.END
    way = np.clip(time / 2, 0, 1) * (last - first)
    x = first + way + swing * np.sin(20 * time) * (time > 2)
    still = np.zeros_like(time)
    position = np.stack([x, still, first + way, first + way, still + height], axis=1)
    reference = np.stack([first + way, still + height], axis=1)
    return Leg(
        time=time,
        reference=reference,
        commanded=reference,
        states=State(position, np.zeros_like(position)),
        voltage=np.zeros((time.size - 1, 2)),
        measures=LegMeasures(*jnp.zeros(10)),
    )


def test_the_committed_picture_has_the_shape_that_its_script_gives_it(script, committed):
    runs = run(script, swing=0.005), run(script, swing=0.0003)
    drawn = script.drawing(consistent(), *runs, leg_time=2.0)
    assert shape(drawn) == shape(committed)


@pytest.mark.slow
def test_the_committed_picture_is_the_scripts_but_for_its_numbers(script, committed):
    assert shape(script.picture()) == shape(committed)


def test_the_picture_moves_without_a_script_and_asks_for_nothing(committed):
    assert len(committed.encode()) < LARGEST
    assert "<script" not in committed
    assert "href" not in committed
    assert set(re.findall(r"https?://[^\"]+", committed)) == {"http://www.w3.org/2000/svg"}
    assert committed.count("@keyframes") > 10


def test_every_moving_part_has_its_motion(committed):
    drawn = {
        own.get("id") for own in ET.fromstring(committed).iter() if own.get("class") == "m"
    }
    assert drawn == set(re.findall(r"@keyframes (s\d-\w+)", committed))


def test_the_readme_says_what_is_to_be_seen(committed):
    assert re.search(
        r"!\[A cable robot[^\]]{80,}\]\(docs/robot\.svg\)", pages.text_of("README.md")
    )
