"""Laws and estimators are chosen by what predicts the rest of a record."""

import jax.numpy as jnp
import numpy as np
import pytest

from identification.axis.law import axis_laws
from identification.axis.log import AxisLog
from identification.axis.motion import AxisParameters, axis_positions

GAIN = 35.0


def log_of(*truth):
    time = 0.01 * np.arange(900)
    voltage = 3.0 * np.sin(2.1 * time) + 1.5 * np.sin(6.7 * time + 1.0)
    positions = axis_positions(
        AxisParameters(*truth),
        GAIN * jnp.asarray(voltage[:-1]),
        steps=jnp.full(len(time) - 1, 0.01),
        start=jnp.array(0.05),
    )
    noise = 1e-5 * np.random.default_rng(3).normal(size=len(time))
    return AxisLog(time, voltage, np.asarray(positions) + noise)


@pytest.mark.slow
def test_an_axis_that_resists_one_way_more_gets_the_extended_law():
    laws = axis_laws(log_of(90.0, 190.0, 22.0, -3.0, -80.0), gain=GAIN)
    assert laws.extended_is_preferred
    assert laws.preferred is laws.extended
    assert abs(float(laws.extended.parameters.viscous_difference) + 80.0) < 1.0


@pytest.mark.slow
def test_an_axis_that_does_not_keeps_the_usual_law():
    laws = axis_laws(log_of(90.0, 190.0, 22.0, -3.0), gain=GAIN)
    assert laws.preferred is laws.usual
    assert abs(laws.usual_ahead - laws.extended_ahead) < 0.1 * laws.usual_ahead


def test_a_record_that_is_too_short_holds_nothing_out():
    whole = log_of(90.0, 190.0, 22.0, -3.0)
    short = AxisLog(whole.time[:70], whole.voltage[:70], whole.position[:70])
    laws = axis_laws(short, gain=GAIN)
    assert np.isnan(laws.usual_ahead)
    assert laws.preferred is laws.usual
