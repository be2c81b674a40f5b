"""A value that is computed once: nothing but its computation changes."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.numerics.once import once

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
