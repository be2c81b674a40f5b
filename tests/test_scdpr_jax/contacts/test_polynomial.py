"""Polynomials in a step's time: zeros, moments, and instants of time."""

import hypothesis
import hypothesis.strategies as st
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.contacts.polynomial import (
    Cubic,
    Quadratic,
    combination,
    cubic_between,
    fall,
    falling_zero,
    moment,
)

EPS = np.finfo(float).eps
number = st.floats(-2, 2).map(lambda x: round(x, 6))
instant = st.floats(0, 1)


def quadratic(*parts):
    return Quadratic(*(jnp.asarray(float(part)) for part in parts))


@hypothesis.given(parts=st.tuples(number, number, number), instant=instant, time=instant)
def test_a_later_polynomial_is_the_same_in_the_time_since_then(parts, instant, time):
    polynomial = quadratic(*parts)
    later = polynomial.later(jnp.asarray(instant))
    assert abs(float(later(time - instant) - polynomial(time))) <= 32 * EPS * 6


@hypothesis.given(parts=st.tuples(number, number, number), left=instant)
@pytest.mark.parametrize("order", range(4))
def test_a_moment_is_the_integral_until_the_step_s_end(order, parts, left):
    nodes, weights = np.polynomial.legendre.leggauss(6)
    since = left * (nodes + 1) / 2
    values = sum(part * since**n for n, part in enumerate(parts)) * (left - since) ** order
    found = float(moment(order, jnp.asarray(left), quadratic(*parts)))
    assert abs(found - left / 2 * weights @ values) <= 32 * EPS


@hypothesis.given(parts=st.tuples(number, number, number))
def test_a_falling_zero_is_one_and_the_polynomial_falls_there(parts):
    zero, exists = falling_zero(quadratic(*parts))
    constant, linear, square = parts
    discriminant = linear**2 - 4 * square * constant
    if not exists:
        assert zero == 0
        falling_line = square == 0 and linear < 0
        assert not falling_line
        assert discriminant <= 0 or square > 0 or (square == 0 and linear >= 0) or linear <= 0
        return
    # Backwards stable: the nearby polynomial that has this zero differs by roundings.
    size = sum(abs(part) * abs(float(zero)) ** n for n, part in enumerate(parts))
    assert abs(float(quadratic(*parts)(zero))) <= 16 * EPS * size
    assert linear + 2 * square * float(zero) <= 8 * EPS * (abs(linear) + 2 * abs(square * zero))


@pytest.mark.parametrize("set_going", [True, False])
def test_what_stands_as_it_falls_stops_at_once_unless_it_has_just_been_set_going(set_going):
    reserve = Cubic(quadratic(0.0, -1.0, 0.0), jnp.asarray(0.0))
    time, falls = fall(reserve, left=1.0, set_going=jnp.asarray(set_going))
    assert bool(falls) is not set_going
    assert float(time) == float(set_going)


def test_what_rises_from_zero_falls_at_its_other_zero():
    reserve = Cubic(quadratic(0.0, 1.0, -2.0), jnp.asarray(0.0))
    time, falls = fall(reserve, left=1.0, set_going=jnp.asarray(True))
    assert bool(falls)
    assert float(time) == 0.5


@hypothesis.given(start=number, end=number, slope=number, end_slope=number, time=instant)
def test_a_cubic_has_the_values_and_slopes_of_both_ends(start, end, slope, end_slope, time):
    ends = (jnp.asarray(part) for part in (start, end, slope, end_slope))
    start_, end_, slope_, end_slope_ = ends
    cubic = cubic_between(start_, end_, slope=slope_, end_slope=end_slope_)
    hermite = (
        start * (1 + 2 * time) * (1 - time) ** 2
        + slope * time * (1 - time) ** 2
        + end * time**2 * (3 - 2 * time)
        + end_slope * time**2 * (time - 1)
    )
    assert abs(float(cubic(jnp.asarray(time))) - hermite) <= 64 * EPS * 8


def test_a_plain_zero_leaves_its_polynomial_out():
    lost = quadratic(np.nan, np.nan, np.nan)
    kept = combination((1, quadratic(1, 2, 3)), (0, lost), (-2, quadratic(1, 1, 1)))
    assert [float(part) for part in kept] == [-1, 0, 1]
