import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.interpolate import BSpline

from scdpr_jax.command.trajectory import rest_to_rest
from tuning.plan.profile import Course, pace_values, plain_moments, spline_moments

START, END = np.array([0.3, 0.55]), np.array([1.9, 0.75])


def course(order=2.0, lower_time=2.0):
    return Course(START, END, np.array([lower_time, 2.0]), np.array(order))


@pytest.mark.parametrize("count", [6, 17, 40])
def test_the_splines_are_those_of_clamped_even_knots_but_the_outer_two(count):
    duration, time = 1.9, np.linspace(-0.1, 2.1, 201)
    every = count + 4
    inner = np.linspace(0.0, duration, every - 3)
    knots = np.concatenate([np.zeros(4), inner, np.full(4, duration)])
    reference = BSpline(knots, np.eye(every)[:, 2:-2], 4)
    inside = ((time >= 0) & (time < duration))[:, None]
    made = spline_moments(time, duration=duration, count=count)
    for order, own in enumerate(made):
        within = reference.derivative(order)(np.clip(time, 0.0, duration))
        # Some roundings of the largest value, 2.5 or up to 3e3 1/s².
        np.testing.assert_allclose(
            own, np.where(inside, within, 0.0), atol=1e-14 * max(1.0, np.max(np.abs(own)))
        )


@pytest.mark.parametrize("part", [0, 1])
def test_every_spline_begins_and_ends_at_rest(part):
    near = np.array([1e-9, 2.0 - 1e-9])
    # Value and slope go to zero with the distance, the slope by a curvature of 1e3 1/s².
    assert np.max(np.abs(spline_moments(near, duration=2.0, count=9)[part])) < 1e-4


def test_the_plain_profile_is_the_papers():
    time = np.linspace(0.0, 2.5, 26)
    leg = rest_to_rest(jnp.asarray(START), jnp.asarray(END), duration=2.0)
    # The same cubic by another scheme: some roundings of 2 m.
    places = jax.vmap(leg.position)(jnp.asarray(time))
    np.testing.assert_allclose(plain_moments(course(), time).value, places, atol=4e-15)


@pytest.mark.parametrize("order", [2.0, 4.0, 8.0, 10.0])
def test_a_pace_has_the_speed_of_its_formula(order):
    s = np.linspace(0.0, 1.0, 41)[:-1]
    moments = plain_moments(Course(np.zeros(2), np.ones(2), np.ones(2), np.array(order)), s)
    speed = (order + 1) / (order - 1) * (1 - s**order - (1 - s) ** order)
    np.testing.assert_allclose(moments.slope[:, 0], speed, atol=1e-13)
    ends = pace_values(np.array([-1.0, 0.0, 1.0, 2.0]), duration=1.0, order=order)
    np.testing.assert_allclose(ends, [0, 0, 1, 1], atol=1e-15)


@pytest.mark.parametrize("part", [0, 1])
def test_the_profiles_derivatives_are_its_differences(part):
    # Away from the ends, where the lower carriage's acceleration jumps.
    time, h = np.linspace(0.05, 1.85, 77), 1e-5
    given = course(4.0, lower_time=1.9)
    ahead, behind = (plain_moments(given, time + way) for way in (h, -h))
    slope = (ahead[part] - behind[part]) / (2 * h)
    exact = plain_moments(given, time)[part + 1]
    assert np.max(np.abs(slope - exact)) < 1e-7 * np.max(np.abs(exact))


def test_lower_carriage_and_height_have_times_of_their_own():
    moments = plain_moments(course(lower_time=1.5), np.array([1.5, 2.0]))
    assert moments.value[:, 0].tolist() == pytest.approx([END[0], END[0]], abs=1e-15)
    assert moments.value[0, 1] < END[1] == pytest.approx(moments.value[1, 1], abs=1e-15)
