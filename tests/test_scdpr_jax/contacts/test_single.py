"""Events of one carriage in a step: where it leaves its branch, and what that is worth."""

import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.contacts.polynomial import Cubic, Quadratic
from scdpr_jax.contacts.single import Assumed, branch_at_start, deviation

LIMIT = 1.0


def assumed(branch, velocity, load, *, bend=0.0):
    """A carriage without cables' stiffness, on a branch."""
    numbers = (jnp.asarray(float(number)) for number in (branch, bend, LIMIT, 0.0))
    branch, bend, limit, stiffness = numbers
    velocity, load = (Quadratic(*map(jnp.asarray, p)) for p in (velocity, load))
    return Assumed(branch, Cubic(velocity, bend), load, limit, stiffness)


def moments_of(difference, *, begin=0.0, end=1.0):
    """Moments of a function of the step's time, by Gauss-Legendre."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    at = begin + (end - begin) * (nodes + 1) / 2
    values = (end - begin) / 2 * weights * difference(at)
    return [np.sum(values * (1 - at) ** order) for order in range(4)]


def assert_moments(found, expected):
    # Closed forms of polynomials of a few terms near 1: some ten roundings.
    np.testing.assert_allclose(found.moments, expected, rtol=0, atol=16 * np.finfo(float).eps)


@pytest.mark.parametrize(
    ("velocity", "load", "branch"),
    [(0.1, -9.0, 1), (-1e-9, 9.0, -1), (0.0, 1.0, 0), (0.0, -1.01, -1), (0.0, 1.01, 1)],
)
def test_a_step_begins_on_the_branch_of_its_velocity_or_else_of_its_load(
    velocity, load, branch
):
    found = branch_at_start(jnp.asarray(velocity), jnp.asarray(load), jnp.asarray(LIMIT))
    assert float(found) == branch


def test_what_sticks_is_at_rest_to_the_bit_and_what_slides_is_left_alone():
    sticking = deviation(assumed(1, (0.5, -1.0, 0.0), (0.0, 0.0, 0.0))).departure(1)
    sliding = deviation(assumed(1, (0.5, 0.0, 0.0), (0.0, 0.0, 0.0))).departure(1)
    velocity = jnp.array([3.0, 1e-17, 0.0, 0.0, 0.0])
    assert sticking.at_rest(velocity) == {1: 0.0}
    assert sliding.at_rest(velocity) == {1: velocity[1]}


def test_a_carriage_that_slides_on_deviates_by_nothing():
    found = deviation(assumed(1, (0.5, -0.2, 0.0), (0.8, 0.0, 0.0)))
    assert_moments(found, np.zeros(4))
    assert not found.sticks


@pytest.mark.parametrize("branch", [1, -1])
def test_a_carriage_that_stops_sticks_under_a_small_load(branch):
    velocity = (branch * 0.5, -branch * 1.0, 0.0)
    found = deviation(assumed(branch, velocity, (0.2, 0.1, -0.3)))
    friction = branch * LIMIT
    assert_moments(
        found, moments_of(lambda t: friction - (0.2 + 0.1 * t - 0.3 * t**2), begin=0.5)
    )
    assert found.sticks


@pytest.mark.parametrize("branch", [1, -1])
def test_a_carriage_that_stops_under_a_large_load_turns_round(branch):
    found = deviation(
        assumed(branch, (branch * 0.5, -branch * 1.0, 0.0), (-branch * 1.5, 0, 0))
    )
    assert_moments(found, moments_of(lambda t: 2 * branch * LIMIT + 0 * t, begin=0.5))
    assert not found.sticks


@pytest.mark.parametrize("branch", [1, -1])
def test_a_carriage_that_would_turn_round_for_a_moment_sticks(branch):
    # The load passes the limit by a little as the carriage stops, and falls.
    load = (-branch * 1.02, branch * 0.04, 0.0)
    found = deviation(assumed(branch, (branch * 0.25, -branch * 1.0, 0.0), load))
    friction = branch * LIMIT
    assert_moments(found, moments_of(lambda t: friction - load[0] - load[1] * t, begin=0.25))
    assert found.sticks


@pytest.mark.parametrize("side", [1, -1])
def test_a_held_carriage_breaks_away_where_its_load_passes_the_limit(side):
    found = deviation(assumed(0, (0.0, 0.0, 0.0), (side * 0.5, side * 1.0, 0.0)))
    assert_moments(found, moments_of(lambda t: side * (0.5 + t - LIMIT), begin=0.5))
    assert not found.sticks


def test_others_feel_what_the_friction_of_a_held_carriage_lacks_and_itself_does_not():
    found = deviation(assumed(0, (0.0, 0.0, 0.0), (0.1, 0.2, 0.3)))
    assert_moments(found, np.zeros(4))
    expected = moments_of(lambda t: -0.3 * t**2)[2:]
    pulls = found.departure(3, jnp.asarray(0.3)).deviations[3].pulls
    np.testing.assert_allclose(pulls, expected, rtol=0, atol=np.finfo(float).eps)


def test_a_carriage_that_has_stopped_may_break_away_again():
    found = deviation(assumed(1, (0.25, -1.0, 0.0), (-0.25, -1.0, 0.0)))
    held = moments_of(lambda t: LIMIT + 0.25 + t, begin=0.25, end=0.75)
    slid = moments_of(lambda t: 2 * LIMIT + 0 * t, begin=0.75)
    assert_moments(found, np.add(held, slid))
    assert not found.sticks


@pytest.mark.parametrize("branch", [1, -1])
def test_a_carriage_is_never_turned_round_by_a_load_that_drives_it_on(branch):
    # It crept off just before, under a load that has hardly passed the limit: what the
    # velocity's polynomial has of it in the step is its own error.
    velocity = (branch * 1e-7, branch * 1e-3, -branch * 2e-3)
    found = deviation(assumed(branch, velocity, (branch * 1.001, 0.0, 0.0)))
    assert_moments(found, np.zeros(4))


def test_a_bent_velocity_stops_where_its_cubic_does():
    errors = []
    for size in (0.1, 0.05):
        bend = size * 0.5
        found = deviation(assumed(1, (0.5, -1.0, 0.0), (0.0, 0.0, 0.0), bend=bend))
        # Friction's moment of order 0 is the time that is left after the stop.
        stop = 1 - float(found.moments[0])
        roots = np.roots([bend, -bend, -1.0, 0.5])
        true = min(roots[np.isreal(roots)].real, key=lambda root: abs(root - 0.5))
        errors.append(abs(stop - true))
    # One step of Newton's errs by its correction's square times the curvature, which is the
    # bend's alone here: as its cube.
    assert errors[0] / errors[1] == pytest.approx(8, rel=0.2)
    assert errors[0] < 1e-4
