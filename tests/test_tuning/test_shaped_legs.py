import jax
import jax.numpy as jnp
import pytest

from scdpr_jax.shaper import Shaper
from tuning.catalogue import zvd
from tuning.shaped_legs import shaped_leg, there_and_back

START, END = jnp.array([0.3, 0.55]), jnp.array([1.9, 0.55])
ROUNDING = 16 * float(jnp.finfo(START.dtype).eps) * 2  # a few operations on metres below 2


def test_a_shaped_leg_takes_its_time_and_ends_at_its_pose():
    leg = shaped_leg(START, END, duration=2.0, shaper=zvd(3.0, 0.01))
    assert abs(float(leg.duration) - 2.0) <= ROUNDING
    assert jnp.max(jnp.abs(leg.position(jnp.asarray(2.0)) - END)) <= ROUNDING


def test_a_shaped_manoeuvre_reaches_its_turning_pose():
    manoeuvre = there_and_back(START, END, leg_time=2.0, shaper=zvd(3.0, 0.01))
    assert jnp.max(jnp.abs(manoeuvre.position(jnp.asarray(2.0)) - END)) <= ROUNDING


def test_a_leg_shorter_than_twice_its_shaper_is_refused():
    shaper = Shaper([0.0, 0.6], [0.5, 0.5])
    with pytest.raises(Exception, match="more than twice"):
        jax.jit(lambda time: shaped_leg(START, END, duration=time, shaper=shaper).duration)(1.0)
