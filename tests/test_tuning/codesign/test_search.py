"""A small co-design: two settings, two heights, two legs."""

import dataclasses
import functools
import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.shaper import ShapedTrajectory
from scdpr_jax.command.trajectory import BezierLeg, rest_to_rest
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.codesign import (
    co_design,
    evaluate,
    front,
    knee,
    models,
    outcomes,
    references,
    usual_move_times,
)
from tuning.codesign.search import Search, _starts
from tuning.codesign.shaped_legs import shaped
from tuning.codesign.unknowns import Unknowns, command, law, plain_profile, start
from tuning.loop.admissible import admissible, slack_of
from tuning.loop.flexible_margins import flexible_margins
from tuning.shapers.catalogue import CATALOGUE

ROBOT = exact(
    replace(
        consistent(),
        {
            "friction_coefficient": 0.018,
            "drive_inertia": 0.0145,
            "drive_damping": 0.2013,
        },
    )
)
SETTINGS = tuple(replace(ROBOT, {"effective_pretension": t}) for t in (60.0, 110.0))
TIMES = (2.3, 2.9)
HEIGHTS = (0.25, 0.9)


def made(scale, heights, ends):
    robots = [
        replace(
            robot,
            {"effective_pretension": scale * float(robot.cable.effective_pretension)},
        )
        for robot in SETTINGS
    ]
    return models(robots, begin=0.3, ends=ends, heights=heights)


SEEN = made(1.0, (0.3, 0.85), (1.1, 1.9))
UNSEEN = made(1.02, (0.5, 0.7), (0.9, 1.5))


@pytest.fixture(scope="module")
def within():
    return admissible(SETTINGS, HEIGHTS)


@pytest.fixture(scope="module")
def few_lanes():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(outcomes, "LANES", 8)
        patch.setattr(outcomes, "SLOPED_LANES", 2)
        yield


@pytest.fixture(scope="module")
def designs(within, few_lanes):
    return front(SEEN, within, move_times=TIMES)


def slack(controllers, heights):
    robots = jax.tree.map(lambda *leaves: jnp.stack(leaves), *SETTINGS)
    each = jax.tree.map(lambda *leaves: np.stack(leaves), *controllers)
    return slack_of(flexible_margins(robots, np.asarray(heights), each))


def test_every_admissible_controller_keeps_its_margins(within):
    shares = ((0.0, 0.0), (0.25, 0.0), (0.5, 0.5), (0.8, 0.0), (1.0, 0.2))
    controllers = [within.controller(jnp.asarray(share)) for share in shares]
    # Other heights than the bounds were found at.
    assert np.all(slack(controllers, [0.45, 0.88]) >= 0)


def test_where_no_gains_keep_the_margins_the_most_damped_are_left():
    heavy = replace(ROBOT, {"end_effector_mass": 4000.0})
    found = admissible([heavy, heavy], HEIGHTS)
    np.testing.assert_array_equal(found.lowest, found.highest)
    assert found.share(25.0, 1.0) == (0.03, 0.5)


def test_the_bounds_are_no_further_than_the_margins_ask(within):
    # A degree of reserve and what the search leaves: three degrees below they are missed.
    span = np.asarray(within.highest - within.lowest)
    controllers = [
        within.controller(jnp.asarray([share, -np.deg2rad(3.0) / span.min()]))
        for share in (0.0, 0.2, 0.4, 0.6, 1.0)
    ]
    assert np.all(slack(controllers, HEIGHTS) < 0)


def test_a_share_inside_the_bounds_is_found_again(within):
    wish = (0.4, 0.6)
    crossover = float(within.crossover[0] + 0.4 * (within.crossover[-1] - within.crossover[0]))
    low, high = (
        np.interp(crossover, within.crossover, bound)
        for bound in (within.lowest, within.highest)
    )
    np.testing.assert_allclose(within.share(crossover, low + 0.6 * (high - low)), wish)


def test_the_plain_profile_is_the_curve_of_section_6_2():
    raised = BezierLeg(jnp.asarray(plain_profile())[:, None] * jnp.ones((1, 2)), 1.0)
    usual = rest_to_rest([0.0, 0.0], [1.0, 1.0], duration=1.0)
    time = jnp.linspace(0.0, 1.0, 21)
    np.testing.assert_allclose(
        jax.vmap(raised.position)(time), jax.vmap(usual.position)(time), atol=1e-14
    )


def test_unknowns_survive_a_row():
    row = jnp.arange(12.0)
    np.testing.assert_array_equal(Unknowns.of(row).flat(), row)


@pytest.mark.parametrize("seed", range(3))
def test_whatever_the_unknowns_the_move_takes_its_time(within, seed):
    row = jnp.asarray(np.random.default_rng(seed).normal(0, 2, 12))
    told = law(Unknowns.of(row), jnp.asarray(2.3), within)
    np.testing.assert_allclose(told.leg_time + told.shaper.duration, 2.3, rtol=1e-12)
    assert float(told.leg_time) > 0
    assert np.all(np.asarray(told.shaper.amplitudes) > 0)


def test_a_command_is_the_shaped_leg(within):
    row = jnp.asarray(np.random.default_rng(4).normal(0, 1, 12))
    told = law(Unknowns.of(row), jnp.asarray(2.3), within)
    on = outcomes.grid(2.3, 2e-3)
    share = command(told, on=on).share
    leg = BezierLeg(told.profile[:, None] * jnp.ones((1, 2)), told.leg_time)
    whole = ShapedTrajectory(leg, told.shaper)
    expected = jax.vmap(whole.position)(jnp.asarray(on.time) + 2.3)[:, 0]
    np.testing.assert_allclose(share, expected, atol=1e-12)
    assert float(share[0]) == 0.0
    assert abs(float(share[on.moving]) - 1) <= 1e-12


def test_a_start_is_nearly_the_catalogues_shaper(within):
    shaper = CATALOGUE[0].design(3.0, 0.0)
    point = start(shaper, move_time=2.3, gains=(0.5, 0.2))
    on = outcomes.grid(2.3, 2e-3)
    near = command(law(point, jnp.asarray(2.3), within), on=on).share
    exactly = command(shaped(published_pd(), shaper, move_time=2.3), on=on).share
    # Parts of one impulse 15 ms apart at the most, at a speed of one way a second.
    assert float(jnp.max(jnp.abs(near - exactly))) <= 15e-3


@pytest.mark.slow
def test_residuals_change_as_their_derivatives_say(within):
    model = jax.tree.map(lambda leaf: jnp.asarray(leaf[1]), SEEN)
    # Exact angles: a staircase has no differences to compare with.
    on = dataclasses.replace(outcomes.grid(2.3, 2e-3), counts=1e12)
    random = np.random.default_rng(2)
    row = start(CATALOGUE[0].design(3.0, 0.0), move_time=2.3, gains=(0.5, 0.3)).flat()
    along = jnp.asarray(random.normal(0, 1, row.size))

    def residuals(row):
        told = command(law(Unknowns.of(row), jnp.asarray(2.3), within), on=on)
        return outcomes._leg(model, told, on).residuals

    # One program for values and slopes: it takes longer to compile than to run.
    both = jax.jit(lambda row: jax.jvp(residuals, (row,), (along,)))
    _, slope = both(row)
    step = 1e-5
    ahead, behind = both(row + step * along)[0], both(row - step * along)[0]
    difference = (ahead - behind) / (2 * step)
    scale = float(jnp.max(jnp.abs(slope)))
    assert scale > 1.0
    np.testing.assert_allclose(difference, slope, atol=2e-3 * scale)


@pytest.mark.slow
def test_the_vibration_never_rises_with_the_move_time(designs):
    assert all(
        before.move_time < after.move_time and before.vibration >= after.vibration
        for before, after in itertools.pairwise(designs)
    )


@pytest.mark.slow
def test_a_design_is_never_worse_than_its_starts(designs, within):
    first = designs[0]
    starts = _starts(SEEN, within, first.move_time)[::4]
    law = Search(SEEN, within, max(TIMES)).objective(first.move_time).law
    laws = [law(jnp.asarray(one.point)) for one in starts]
    evaluated = functools.partial(evaluate, SEEN, longest=max(TIMES))
    assert all(first.cost <= evaluated(each).cost for each in laws)


def vibrations(seen, design):
    """Of a design and of what it is compared with, on models [m]."""
    evaluated = functools.partial(evaluate, seen, longest=max(TIMES))
    laws = references(seen, move_time=design.move_time)
    return evaluated(design.law).vibration, [evaluated(one).vibration for one in laws.values()]


def test_the_models_vibrate_half_as_much_as_with_a_zv_shaper_or_without(designs):
    after, before = vibrations(SEEN, designs[0])
    assert after <= 0.5 * min(before)


def test_models_that_were_not_seen_vibrate_less_too(designs):
    # Eight models are few: between two heights much is left open, most where it is fast.
    after, before = vibrations(UNSEEN, designs[-1])
    assert after < min(before)


@pytest.mark.slow
def test_with_more_heights_models_that_were_not_seen_vibrate_half_as_much(within):
    heights, ends = (0.2, 0.38, 0.55, 0.72, 0.9), (0.7, 1.1, 1.5, 1.9)
    design = co_design(made(1.0, heights, ends), within, move_time=2.6, longest=max(TIMES))
    unseen = made(1.02, (0.3, 0.47, 0.63, 0.8), (0.9, 1.3, 1.7))
    after, before = vibrations(unseen, design)
    assert after <= 0.5 * min(before)


def test_the_drives_keep_their_limit(designs):
    assert all(one.keeps_voltage(float(ROBOT.drive.voltage_limit)) for one in designs)


def test_the_knee_is_one_of_the_front(designs):
    assert any(knee(designs) is one for one in designs)


@pytest.mark.slow
def test_a_move_that_the_drives_cant_do_is_refused(within, few_lanes):
    with pytest.raises(ValueError, match="too short for the drives"):
        front(SEEN, within, move_times=(1.0,))


def test_nothing_is_asked_for_where_no_search_has_a_start(within):
    asked = []

    def designer(search, starts, progress):
        asked.append(len(starts))
        return []

    # Not even one shaper of the catalogue ends in a tenth of a second.
    with pytest.raises(ValueError, match="too short for the drives"):
        front(SEEN, within, move_times=(0.1,), designer=designer)
    assert not asked


def test_usual_move_times_begin_where_the_drives_just_can():
    times = usual_move_times(SEEN, count=4)
    assert list(times) == sorted(times)
    # 1.6 m at 1.5 times the mean speed, 10 V and 0.482 N m/V against 0.2013 N m s.
    top_speed = 10 * float(ROBOT.drive.torque_per_volt) / 0.2013 * 0.073
    assert times[0] > 1.5 * 1.6 / top_speed
