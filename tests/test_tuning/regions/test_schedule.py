import dataclasses
import itertools

import equinox as eqx
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.command.shaper import ShapedTrajectory, residual_vibration
from scdpr_jax.command.trajectory import rest_to_rest
from tuning.regions.schedule import (
    HANDOVER,
    ScheduledTrajectory,
    grids_of,
    handover_widths,
    schedule_of,
    scheduled_samples,
)
from tuning.result.regional_shaper import Region, RegionalShaper, ResidualVibration
from tuning.shapers.catalogue import ei, um_zv, zv, zvd

X_EDGES, Y_EDGES = (0.0, 0.8, 1.4, 2.224), (0.0, 0.4, 1.112)
DESIGNS = (
    zv(4.0, 0.01),
    zvd(4.2, 0.0),
    ei(3.9, 0.02),
    ei(3.1, 0.01),
    zv(3.2, 0.0),
    zvd(3.0, 0.01),
)
LEFT = ResidualVibration(0.0, 0.0)
PRETENSION = 350.0
EPS = float(np.finfo(float).eps)


def regional(shaper, x, y, pretension=PRETENSION):
    region = Region(x, y, (pretension, pretension))
    return RegionalShaper(region, sum(y) / 2, shaper, 3.1, (3.0, 3.2), 0.01, True, LEFT)


def tiles(shapers, x_edges, y_edges):
    spans = [(x, y) for y in itertools.pairwise(y_edges) for x in itertools.pairwise(x_edges)]
    return tuple(regional(shaper, x, y) for shaper, (x, y) in zip(shapers, spans, strict=True))


TILES = tiles(DESIGNS, X_EDGES, Y_EDGES)
SCHEDULE = schedule_of(TILES, PRETENSION)
WEIGHTS = eqx.filter_jit(SCHEDULE.weights)
SLOPES = jax.jit(jax.jacfwd(lambda position: SCHEDULE.weights(position)))
LEG = rest_to_rest((0.2, 0.2), (1.9, 0.9), duration=0.9)
SCHEDULED = ScheduledTrajectory(LEG, SCHEDULE)
poses = st.tuples(st.floats(-0.5, 2.7), st.floats(-0.5, 1.6)).map(jnp.asarray)


@eqx.filter_jit
def positions(trajectory, times):
    return jax.vmap(trajectory.position)(times)


@hypothesis.given(position=poses)
def test_weights_are_not_negative_and_sum_to_one(position):
    weights = WEIGHTS(position)
    assert jnp.all(weights >= 0)
    # Polynomials of sixth degree whose terms are at most 15, in two directions.
    assert jnp.abs(jnp.sum(weights) - 1) <= 64 * EPS


@pytest.mark.parametrize(("axis", "edges"), [(0, X_EDGES), (1, Y_EDGES)], ids=["x", "y"])
def test_neither_weights_nor_their_slopes_jump_at_a_line_or_at_a_hand_overs_ends(axis, edges):
    step = 1e-6  # m
    widths = handover_widths(spans(edges))
    places = [line + k * width / 2 for line, width in widths.items() for k in (-1, 0, 1)]
    # |S'| ≤ 15/8 and |S''| ≤ 10/√3 in units of the narrowest hand-over.
    narrowest = min(widths.values())
    for place in [*places, edges[0], edges[-1]]:
        # Across, in a region's middle.
        below, above = (
            jnp.full(2, 0.2).at[axis].set(place + side * step / 2) for side in (-1, 1)
        )
        weight, slope = (jnp.max(jnp.abs(f(above) - f(below))) for f in (WEIGHTS, SLOPES))
        assert weight <= 15 / 8 * step / narrowest + 64 * EPS
        assert slope <= 10 / np.sqrt(3) * step / narrowest**2 + 64 * EPS / narrowest


def spans(edges):
    return list(itertools.pairwise(edges))


def test_hand_overs_leave_half_of_every_region_alone():
    for edges in (X_EDGES, Y_EDGES, (0.0, 0.1, 1.0, 1.05)):
        widths = handover_widths(spans(edges))
        for low, high in spans(edges):
            taken = (widths.get(low, 0.0) + widths.get(high, 0.0)) / 2
            assert taken <= HANDOVER * (high - low) * (1 + 4 * EPS)


def test_in_the_middle_of_a_region_its_shaper_counts_alone():
    for number, one in enumerate(TILES):
        middle = jnp.asarray([sum(one.region.x) / 2, sum(one.region.y) / 2])
        assert WEIGHTS(middle).tolist() == [float(i == number) for i in range(len(TILES))]


def test_a_leg_within_a_regions_middle_is_shaped_as_by_its_shaper():
    leg = rest_to_rest((1.0, 0.6), (1.2, 0.9), duration=0.4)
    times = jnp.linspace(-0.1, 1.5, 200)
    found = positions(ScheduledTrajectory(leg, SCHEDULE), times)
    expected = positions(ShapedTrajectory(leg, TILES[4].shaper), times)
    assert jnp.max(jnp.abs(found - expected)) <= 8 * EPS


def test_beyond_the_frame_the_nearest_region_counts():
    assert WEIGHTS(jnp.asarray([-3.0, -2.0])).tolist() == WEIGHTS(jnp.zeros(2)).tolist()


@hypothesis.given(position=poses)
def test_the_shaper_of_a_pose_is_positive_and_ends_where_it_should(position):
    shaper = eqx.filter_jit(SCHEDULE.at)(position)
    assert jnp.all(shaper.amplitudes >= 0)
    assert jnp.abs(jnp.sum(shaper.amplitudes) - 1) <= 64 * EPS
    counts = WEIGHTS(position) > 0
    longest = jnp.max(jnp.where(counts, SCHEDULE.shaper.duration, 0.0))
    assert shaper.duration == longest


def test_a_straight_diagonal_stays_straight():
    # A negative impulse must not bend it, either.
    shapers = (um_zv(4.0, 0.01), *DESIGNS[1:])
    schedule = schedule_of(tiles(shapers, X_EDGES, Y_EDGES), PRETENSION)
    path = positions(ScheduledTrajectory(LEG, schedule), jnp.linspace(0.0, 1.7, 400))
    start, end = LEG.control_points[0], LEG.control_points[-1]
    along = (end - start) / jnp.linalg.norm(end - start)
    off = (path - start[None]) @ jnp.asarray([-along[1], along[0]])
    # 6 regions of 3 impulses, each product rounded.
    assert jnp.max(jnp.abs(off)) <= 32 * EPS


def test_it_starts_at_the_first_and_rests_at_the_last_position():
    times = jnp.asarray([0.0, float(SCHEDULED.duration), 9.0])
    expected = LEG.control_points[jnp.asarray([0, -1, -1])]
    assert jnp.max(jnp.abs(positions(SCHEDULED, times) - expected)) <= 64 * EPS
    assert SCHEDULED.duration == LEG.duration + max(one.duration for one in DESIGNS)


def test_once_in_a_regions_middle_it_is_the_regions_shaped_reference():
    times = jnp.linspace(0.0, 1.7, 300)
    alone = jax.vmap(WEIGHTS)(positions(LEG, times))[:, -1] == 1
    assert 50 < int(jnp.sum(alone)) < 250
    expected = positions(ShapedTrajectory(LEG, TILES[-1].shaper), times)
    error = jnp.abs(positions(SCHEDULED, times) - expected)
    assert jnp.max(error[alone]) <= 8 * EPS
    assert jnp.max(error[~alone]) > 1e-3


def test_samples_are_shaped_as_the_trajectory_is():
    period = jnp.asarray(1e-3)
    times = period * jnp.arange(1700.0)
    samples = positions(LEG, times)
    found = jax.jit(scheduled_samples)(SCHEDULE, samples, places=samples, period=period)
    # Between samples they count as straight: h² |a| / 8, with |a| = 6 |way| / duration².
    way = jnp.linalg.norm(LEG.control_points[-1] - LEG.control_points[0])
    tolerance = period**2 / 8 * 6 * way / LEG.duration**2
    assert jnp.max(jnp.abs(found - positions(SCHEDULED, times))) <= tolerance


def test_samples_with_the_legs_end_as_their_place_have_its_shaper():
    period = jnp.asarray(1e-3)
    samples = positions(LEG, period * jnp.arange(1700.0))
    end = jnp.asarray([1.5, 0.45])
    places = jnp.broadcast_to(end[None], samples.shape)
    found = jax.jit(scheduled_samples)(SCHEDULE, samples, places=places, period=period)
    shaped = positions(ShapedTrajectory(LEG, SCHEDULE.at(end)), period * jnp.arange(1700.0))
    way = jnp.linalg.norm(LEG.control_points[-1] - LEG.control_points[0])
    assert jnp.max(jnp.abs(found - shaped)) <= period**2 / 8 * 6 * way / LEG.duration**2


@pytest.mark.slow
def test_position_has_the_derivatives_of_its_finite_differences():
    def position(time, amplitudes, middle, points):
        changed = eqx.tree_at(
            lambda one: (
                one.schedule.shaper.amplitudes,
                one.schedule.columns.middle,
                one.trajectory.control_points,
            ),
            SCHEDULED,
            (amplitudes, middle, points),
        )
        return changed.position(time)

    given = (SCHEDULE.shaper.amplitudes, SCHEDULE.columns.middle, LEG.control_points)
    # In a hand-over, in a region's middle, and at the very end of a hand-over.
    for time in (0.45, 0.7, 0.25):
        check_grads(
            jax.jit(position), (jnp.asarray(time), *given), order=1, modes=("fwd", "rev")
        )


def residual(times, positions, frequency, damping_ratio):
    """Amplitude of a mode after a path along x, times its frequency, as of its end."""
    omega = 2 * np.pi * frequency
    pole = omega * (-damping_ratio + 1j * np.sqrt(1 - damping_ratio**2))
    x = np.asarray(positions)[:, 0]
    middle = (times[1:] + times[:-1]) / 2
    return np.abs(np.sum(np.diff(x) * np.exp(pole * (times[-1] - middle))))


def along(duration):
    return rest_to_rest((0.2, 0.6), (1.9, 0.6), duration=duration)


PAIR = schedule_of(
    (
        regional(zvd(4.0, 0.01), (0.0, 1.1), (0.0, 1.1)),
        regional(ei(3.0, 0.01), (1.1, 2.2), (0.0, 1.1)),
    ),
    PRETENSION,
)
MODE = {"frequency": 3.0, "damping_ratio": 0.01}


def left_by(reference, *, end):
    times = np.linspace(0.0, end, 4000)
    return residual(times, positions(reference, jnp.asarray(times)), **MODE)


def test_a_leg_with_the_schedule_of_its_end_leaves_what_the_end_regions_shaper_does():
    # An EI shaper leaves a twentieth at its frequency; the leg begins in the other region.
    leg = along(1.0)
    shaped = ShapedTrajectory(leg, PAIR.at(leg.control_points[-1]))
    found = left_by(shaped, end=float(shaped.duration))
    known = {name: jnp.asarray(number) for name, number in MODE.items()}
    share = residual_vibration(ei(3.0, 0.01), **known)
    expected = share * left_by(leg, end=1.0)
    assert 0.04 < share < 0.06
    # Midpoints of steps of a third of a millisecond: (ω h)² / 24 of the 1.7 m.
    tolerance = (2 * np.pi * 3.0 * 4e-4) ** 2 / 24 * 1.7
    assert abs(found - expected) <= tolerance
    assert expected > 20 * tolerance


def test_a_hand_over_on_the_way_excites_the_mode():
    leg = along(1.0)
    scheduled = ScheduledTrajectory(leg, PAIR)
    end = float(scheduled.duration)
    with_hand_over = left_by(scheduled, end=end)
    without = left_by(ShapedTrajectory(leg, PAIR.at(leg.control_points[-1])), end=end)
    assert with_hand_over > 3 * without


def test_of_one_region_the_residual_is_its_shapers():
    one = regional(ei(3.1, 0.01), (0.0, 2.2), (0.0, 1.1))
    shaper = schedule_of((one,), PRETENSION).at(jnp.asarray([0.7, 0.3]))
    for frequency in (2.0, 3.1, 4.3):
        known = {"frequency": jnp.asarray(frequency), "damping_ratio": jnp.asarray(0.02)}
        error = residual_vibration(shaper, **known) - residual_vibration(one.shaper, **known)
        assert abs(error) <= 8 * EPS


def test_a_setting_that_was_not_tuned_is_refused():
    with pytest.raises(ValueError, match="none for 200 N, got: 350 to 350 N"):
        schedule_of(TILES, 200.0)


@pytest.mark.parametrize(
    "wrong",
    [
        TILES[:-1],
        (*TILES, TILES[0]),
        (*TILES[:-1], regional(DESIGNS[5], (1.4, 2.224), (0.5, 1.112))),
        tiles(DESIGNS[:2], (0.0, 1.0, 1.0), (0.0, 1.1)),
    ],
    ids=["missing", "twice", "gap", "empty"],
)
def test_regions_that_are_not_a_grid_are_refused(wrong):
    with pytest.raises(ValueError, match="must be a grid"):
        schedule_of(wrong, PRETENSION)


def test_every_range_of_settings_has_its_own_grid():
    others = tuple(
        dataclasses.replace(
            one, region=dataclasses.replace(one.region, pretension=(200.0, 200.0))
        )
        for one in reversed(TILES)
    )
    grids = grids_of((*TILES, *others))
    assert list(grids) == [(350.0, 350.0), (200.0, 200.0)]
    first, second = grids.values()
    assert [one.shaper for one in first] == [one.shaper for one in second]
