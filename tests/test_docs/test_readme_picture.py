"""The README's picture is the one that its script makes."""

import importlib.util
import re
import xml.etree.ElementTree as ET

import pages
import pytest

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


def test_the_committed_picture_is_the_scripts_but_for_its_numbers(committed):
    path = pages.ROOT / "docs/readme_picture.py"
    spec = importlib.util.spec_from_file_location("readme_picture", path)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
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
