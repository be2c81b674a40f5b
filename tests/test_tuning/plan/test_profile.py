import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.command.trajectory import rest_to_rest
from tuning.plan.profile import plain_motion, spline_basis, with_deviation

START, END = jnp.asarray([0.3, 0.55]), jnp.asarray([1.9, 0.75])


@pytest.mark.parametrize("splines", [4, 17])
@pytest.mark.parametrize("part", ["value", "slope"])
def test_every_spline_begins_and_ends_at_rest(splines, part):
    # Just inside the ends, where the splines' own value and slope show: both go to zero
    # with the distance, the slope by a curvature of some 1e3 1/s².
    near = np.array([1e-9, 2.0 - 1e-9])
    assert jnp.max(jnp.abs(getattr(spline_basis(2.0, near, splines=splines), part))) < 1e-4


def test_outside_of_the_leg_the_splines_are_zero():
    basis = spline_basis(2.0, np.array([-0.1, 2.0, 2.5]), splines=9)
    assert not any(jnp.any(part) for part in basis)


@pytest.mark.parametrize(("part", "derivative"), [("value", "slope"), ("slope", "curvature")])
def test_the_splines_derivatives_are_their_differences(part, derivative):
    time, h = np.linspace(0.05, 1.95, 77), 1e-5
    ahead, behind = (spline_basis(2.0, time + way, splines=9) for way in (h, -h))
    slope = (getattr(ahead, part) - getattr(behind, part)) / (2 * h)
    exact = getattr(spline_basis(2.0, time, splines=9), derivative)
    assert jnp.max(jnp.abs(slope - exact)) < 1e-4 * jnp.max(jnp.abs(exact))


def test_the_plain_motion_is_the_papers_profile():
    time = jnp.linspace(0.0, 2.5, 26)
    leg = rest_to_rest(START, END, duration=2.0)
    motion = plain_motion(START, END, leg_time=jnp.asarray(2.0), time=time)
    # The same cubic by another scheme: some roundings of 2 m.
    np.testing.assert_allclose(motion.position, jax.vmap(leg.position)(time), atol=4e-15)


@pytest.mark.parametrize("order", [2, 4, 8, 10])
def test_a_pace_has_the_speed_of_its_formula(order):
    """With the unit leg in a second: its speed over s, and rest at both ends."""
    s = jnp.linspace(0.0, 1.0, 41)[:-1]
    ends = jnp.zeros(2), jnp.ones(2)
    motion = plain_motion(*ends, leg_time=jnp.asarray(1.0), time=s, order=order)
    speed = (order + 1) / (order - 1) * (1 - s**order - (1 - s) ** order)
    np.testing.assert_allclose(motion.velocity[:, 0], speed, atol=1e-13)
    assert motion.position[0, 0] == 0
    after = plain_motion(*ends, leg_time=jnp.asarray(1.0), time=jnp.ones(1), order=order)
    assert after.position[0, 0] == 1


def test_a_deviation_leads_the_lower_carriage_alone():
    time = np.linspace(0.0, 2.0, 21)
    plain = plain_motion(START, END, leg_time=jnp.asarray(2.0), time=jnp.asarray(time))
    led = with_deviation(plain, spline_basis(2.0, time, splines=9), jnp.full(9, 0.01))
    assert jnp.max(jnp.abs(led.position[:, 0] - plain.position[:, 0])) > 5e-3
    np.testing.assert_array_equal(led.position[:, 1], plain.position[:, 1])
