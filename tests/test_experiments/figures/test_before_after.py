"""A leg before and after, as a drawing that stands by itself."""

import re

import numpy as np
import pytest

from experiments.figures.before_after import Side, before_after
from experiments.figures.robot_film import Track
from scdpr_jax.robot.prototype import consistent

TARGET = 1.0


def side(title, swing, *, outcome="so much"):
    """A second of motion, and one in which x_e swings by so much to either side [m]."""
    time = np.linspace(0, 2, 201)
    along = np.clip(time, 0, 1) * TARGET
    x = along + swing * np.sin(20 * time) * (time > 1)
    still = np.zeros_like(time)
    return Side(
        title, Track(title, time, np.stack([x, still, along, along, still + 0.5], 1)), outcome
    )


def drawing(*sides):
    return before_after(consistent(), sides, target=TARGET, leg_time=1.0, name="two <legs>")


def heights(svg):
    """Where both curves are, from the arrival on [px]."""
    curves = re.findall(r'<polyline points="([^"]+)"', svg)
    points = [[tuple(map(float, p.split(","))) for p in curve.split()] for curve in curves]
    return [np.ptp([y for x, y in curve if x > 215]) for curve in points]


def test_both_sides_are_drawn_to_one_scale():
    first, second = heights(drawing(side("a", 0.01), side("b", 0.001)))
    assert first == pytest.approx(10 * second, rel=0.02)


def test_words_are_escaped():
    svg = drawing(side("a < b", 0.01), side("b", 0.001, outcome="1 & 2"))
    assert 'aria-label="two &lt;legs&gt;"' in svg
    assert ">a &lt; b</text>" in svg
    assert ">1 &amp; 2</text>" in svg


def test_who_wants_no_motion_sees_none():
    assert "prefers-reduced-motion: reduce) { .m { animation: none } }" in drawing(
        side("a", 0.01), side("b", 0.001)
    )
