"""The curves of a tuning, held to closed forms and to the margins."""

import math

import numpy as np
import pytest

from experiments.studies.findings.responses import NamedShaper, open_loop
from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper
from tuning.loop.margins import sampled_margins
from tuning.loop.plant import published_plant


def test_the_open_loop_crosses_where_the_margins_say():
    controller = PD(36.0, 0.7, 1e-3)
    margins = sampled_margins(published_plant(), controller)
    crossover = float(margins.gain_crossover)
    loop = open_loop(published_plant(), controller, delay=1, crossover=crossover)
    gain = np.interp(crossover, loop.angular_frequency, loop.gain)
    phase = np.interp(crossover, loop.angular_frequency, loop.phase)
    # Interpolated between 400 points over three decades: 2 % of a frequency apart.
    assert gain == pytest.approx(0.0, abs=0.02)
    assert phase == pytest.approx(-180 + math.degrees(float(margins.phase_margin)), abs=0.1)
    assert np.all(np.abs(np.diff(loop.phase)) < 180)


def test_a_zv_shaper_leaves_nothing_at_its_frequency_and_all_at_twice_it():
    shaper = NamedShaper("ZV", Shaper([0.0, 0.25], [0.5, 0.5]), 0.0, (1.9, 2.1))
    left = shaper.residual(np.array([2.0, 4.0]))
    # cos(pi/2) and one, in double precision.
    assert np.allclose(left, [0.0, 1.0], atol=1e-12)
