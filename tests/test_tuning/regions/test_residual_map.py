"""What the schedule leaves over the workspace, on a grid of nine made-up cells."""

import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.shaper import Shaper, residual_vibration
from scdpr_jax.linear.modes import BOTH_HELD, natural_frequencies
from scdpr_jax.robot.prototype import consistent
from tuning.loop.margins import Margins
from tuning.regions.residual_map import held_mode, residual_map, worst_in_band
from tuning.result.regional_shaper import Region, RegionalShaper, ResidualVibration
from tuning.result.tuning import FittedSetting, Tuning
from tuning.shapers.catalogue import ei, zv

ROBOT = consistent()
PRETENSION = 350.0
COLUMNS = ((0.0, 0.8), (0.8, 1.4), (1.4, 2.224))
# Each row with a height inside of its middle half, where frequencies are measured.
ROWS = (((0.0, 0.42), 0.29), ((0.42, 0.68), 0.55), ((0.68, 1.112), 0.82))
MEASURED = np.array([0.97, 1.0, 1.02, 1.03, 0.98, 1.01, 0.99, 1.02, 0.96])  # of the model's
UNSHAPED = Shaper([0.0], [1.0])
EPS = float(np.finfo(float).eps)


@jax.jit
def model(height):
    return natural_frequencies(ROBOT, height, BOTH_HELD)[0]


def regional(design, x, y, height, ratio):
    frequency = ratio * float(model(jnp.asarray(height)))
    band = (0.98 * frequency, 1.02 * frequency)
    shaper = design(frequency, 0.01)
    known = {"damping_ratio": jnp.asarray(0.01)}
    nominal = residual_vibration(shaper, frequency=jnp.asarray(frequency), **known)
    worst = worst_in_band(shaper, band=jnp.asarray(band), **known)
    left = ResidualVibration(float(nominal), float(worst))
    region = Region(x, y, (PRETENSION, PRETENSION))
    return RegionalShaper(region, height, shaper, frequency, band, 0.01, True, left)


@functools.cache
def tuning_of(design):
    places = [(x, y, height) for y, height in ROWS for x in COLUMNS]
    return Tuning(
        controller=published_pd(),
        margins=Margins(*jnp.ones(6)),
        shapers=tuple(
            regional(design, *place, float(ratio))
            for place, ratio in zip(places, MEASURED, strict=True)
        ),
        predicted=(),
        robots=(FittedSetting(PRETENSION, ROBOT),),
    )


def measured_at(one):
    return jnp.asarray([sum(one.region.x) / 2, one.height])


@pytest.mark.parametrize("design", [zv, ei])
def test_where_a_cell_was_measured_the_residual_is_the_cells(design):
    tuning = tuning_of(design)
    mode = held_mode(tuning, PRETENSION)
    residual = eqx.filter_jit(mode.residual)
    for one in tuning.shapers:
        error = float(residual(measured_at(one))) - one.residual_vibration.worst
        # A frequency's roundings of 1e-15 turn the last impulse by as much.
        assert abs(error) <= 1e-12


def test_the_band_is_the_cells_where_it_was_measured_and_follows_the_model_between():
    mode = held_mode(tuning_of(zv), PRETENSION)
    band = eqx.filter_jit(mode.band)
    for one in tuning_of(zv).shapers:
        assert np.allclose(band(measured_at(one)), one.band, rtol=1e-12)
    # Still in the middle half of the first row, where its ratio counts alone.
    low, high = band(jnp.asarray([0.4, 0.2]))
    expected = MEASURED[0] * float(model(jnp.asarray(0.2)))
    assert (low + high) / 2 == pytest.approx(expected, rel=1e-12)


def test_without_a_shaper_everything_is_left_everywhere():
    found = residual_map(tuning_of(lambda frequency, damping_ratio: UNSHAPED), PRETENSION)
    assert np.max(np.abs(found.residual - 1)) <= 64 * EPS


def test_the_worst_is_the_largest_and_where_it_is_said_to_be():
    tuning = tuning_of(zv)
    found = residual_map(tuning, PRETENSION)
    value, x, y = found.worst
    assert value == found.residual.max()
    again = eqx.filter_jit(held_mode(tuning, PRETENSION).residual)(jnp.asarray([x, y]))
    assert float(again) == pytest.approx(value, rel=1e-9)


def test_away_from_where_they_were_measured_zero_vibration_shapers_leave_more():
    tuning = tuning_of(zv)
    cells = max(one.residual_vibration.worst for one in tuning.shapers)
    assert residual_map(tuning, PRETENSION).worst.value > 3 * cells


def test_the_map_reaches_no_further_than_the_workspace():
    found = residual_map(tuning_of(zv), PRETENSION)
    half = float(ROBOT.lower_carriage.width) / 2
    assert found.x[0] == pytest.approx(half)
    assert found.x[-1] == pytest.approx(float(ROBOT.frame.width) - half)
    assert found.y[0] > float(ROBOT.end_effector.lower_offset)
    assert found.y[-1] < float(ROBOT.frame.height - ROBOT.end_effector.upper_offset)


def test_what_is_promised_is_the_cells_own():
    tuning = tuning_of(zv)
    found = residual_map(tuning, PRETENSION)
    promised = {one.residual_vibration.worst for one in tuning.shapers}
    assert set(np.unique(found.promised)) == promised
    assert found.beyond.value == (found.residual - found.promised).max()


def test_a_wider_band_leaves_no_less():
    tuning = tuning_of(zv)
    wider = dataclasses.replace(
        tuning,
        shapers=tuple(
            dataclasses.replace(one, band=(0.9 * one.frequency, 1.1 * one.frequency))
            for one in tuning.shapers
        ),
    )
    more = residual_map(wider, PRETENSION).residual
    # Both look at the nominal frequency and at a few beside it.
    assert np.mean(more) > np.mean(residual_map(tuning, PRETENSION).residual)
    assert more.max() > residual_map(tuning, PRETENSION).worst.value


def test_a_setting_without_a_robot_is_refused():
    with pytest.raises(ValueError, match="no fitted robot at 200 N"):
        residual_map(tuning_of(zv), 200.0)
