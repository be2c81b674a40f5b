"""A value that is computed once: nothing but its computation changes."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.numerics.once import computed_once, once

VALUES = np.array([0.0, -0.0, 1.0, -3.5, 1e-300, 1e300, np.inf, -np.inf])


@pytest.mark.parametrize("how", [once, jax.jit(once), jax.jit(jax.vmap(once))])
def test_it_returns_what_it_is_given_to_the_bit(how):
    found = np.asarray(how(jnp.asarray(VALUES)))
    np.testing.assert_array_equal(found.view(np.int64), VALUES.view(np.int64))


def test_what_is_not_a_number_stays_so():
    assert np.isnan(jax.jit(once)(jnp.asarray(np.nan)))


def test_derivatives_of_either_direction_pass_through():
    def wrapped(x):
        return once(jnp.sin(once(x)) * x)

    x = jnp.asarray(0.7)
    true = np.sin(0.7) + 0.7 * np.cos(0.7)
    for derive in (jax.grad, jax.jacfwd, jax.jacrev):
        np.testing.assert_allclose(jax.jit(derive(wrapped))(x), true, rtol=1e-15)
    second = 2 * np.cos(0.7) - 0.7 * np.sin(0.7)
    np.testing.assert_allclose(jax.grad(jax.grad(wrapped))(x), second, rtol=1e-14)


def grown(wrap, x):
    """A chain whose values are each used several times by the next."""
    a, b, c = x
    for _ in range(10):
        a, b, c = wrap(a * b + c), wrap(b * c + a), wrap(c * a - b)
    return a, b, c


def multiplications(wrap, function):
    given = tuple(jnp.full(64, number) for number in (0.3, 0.2, 0.1))
    program = jax.jit(lambda x: function(lambda y: grown(wrap, y), x)).lower(given).compile()
    return program.as_text().count(" multiply(")


def value(chain, x):
    return chain(x)


def tangents(chain, x):
    return jax.vmap(lambda t: jax.jvp(chain, (x,), ((t * x[0], x[1], x[2]),))[1])(jnp.ones(3))


@pytest.mark.parametrize("function", [value, tangents])
def test_a_chain_of_values_is_computed_once(function):
    if jax.default_backend() != "cpu":
        pytest.skip("XLA's CPU back end is what computes values anew")
    plain = multiplications(lambda x: x, function)
    assert multiplications(once, function) < plain / 2


@pytest.mark.parametrize("function", [value, tangents])
def test_values_of_several_uses_are_found_in_a_function(function):
    if jax.default_backend() != "cpu":
        pytest.skip("XLA's CPU back end is what computes values anew")
    given = tuple(jnp.full(64, number) for number in (0.3, 0.2, 0.1))

    def plain(x):
        return grown(lambda y: y, x)

    def count(chain):
        program = jax.jit(lambda x: function(chain, x)).lower(given).compile()
        return program.as_text().count(" multiply(")

    # Cheap values may be computed anew, so that it is less of a gain than by hand.
    assert count(computed_once(plain, given)) < 0.9 * count(plain)


def branching(x, turns):
    """A function with each kind of control flow and of called functions."""

    def turn(carry, row):
        carry = jax.lax.cond(
            jnp.sum(carry) > 1.0, jnp.sin, lambda y: jax.nn.relu(y * row), carry
        )
        return carry, jnp.where(carry > 0.2, carry, jnp.clip(carry, -1.0, 1.0) * carry)

    return jax.lax.scan(turn, x, jnp.linspace(0.5, 2.0, turns))


def test_a_function_with_branches_and_loops_stays_the_same():
    x = jnp.array([0.3, -0.4, 1.7])

    def function(x):
        return branching(x, 5)

    same = computed_once(function, x)
    found, expected = (jax.jit(f)(x) for f in (same, function))
    np.testing.assert_allclose(found[1], expected[1], rtol=1e-15)
    found, expected = (jax.jit(jax.jacfwd(f))(x) for f in (same, function))
    np.testing.assert_allclose(found[0], expected[0], rtol=1e-14)
    found, expected = (jax.jit(jax.jacrev(f))(x) for f in (same, function))
    np.testing.assert_allclose(found[0], expected[0], rtol=1e-14)
