"""Sine, cosine and exponential of vectors against the C library."""

import math
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from scalar_functions import by_llvm, read_function

from scdpr_jax.native.scalar.elementary import (
    LARGEST_ANGLE,
    LARGEST_EXPONENT,
    vectorised,
)
from scdpr_jax.native.scalar.program import needed

LANES = 8
RANDOM = np.random.default_rng(3)


def vector_function(function):
    program = vectorised(read_function(function, jnp.zeros(())))
    run = by_llvm(replace(program, body=needed(program.body)), lanes=LANES)

    def many(x):
        return np.concatenate([run([row[:, None]])[0][:, 0] for row in x.reshape(-1, LANES)])

    return many


def error_in_ulp(found, exact):
    return np.max(np.abs(found - exact) / np.spacing(np.abs(exact)))


@pytest.mark.parametrize(
    ("function", "library", "largest", "ulp"),
    [
        (jnp.sin, math.sin, 3.0, 1.5),
        (jnp.cos, math.cos, 1.5, 1.5),
        (jnp.exp, math.exp, 1.0, 1.5),
        (jnp.exp, math.exp, LARGEST_EXPONENT, 2.0),
    ],
)
def test_they_are_exact_to_a_few_roundings(function, library, largest, ulp):
    x = RANDOM.uniform(-largest, largest, 20_000)
    exact = np.array([*map(library, x)])
    assert error_in_ulp(vector_function(function)(x), exact) <= ulp


@pytest.mark.parametrize(("function", "library"), [(jnp.sin, math.sin), (jnp.cos, math.cos)])
def test_large_angles_are_as_exact_as_their_turns(function, library):
    x = RANDOM.uniform(-LARGEST_ANGLE, LARGEST_ANGLE, 20_000)
    exact = np.array([*map(library, x)])
    # Near a zero the error is that of pi's parts, of which the last is 1e-24.
    assert np.max(np.abs(vector_function(function)(x) - exact)) <= 2 * np.finfo(float).eps


def test_beyond_its_range_an_argument_goes_to_the_library():
    far = np.array([1.0, 2e5, -3e9, 1e22, 0.0, -1e5, 12.0, 1e5])
    for function, library in ((jnp.sin, math.sin), (jnp.cos, math.cos)):
        exact = np.array([*map(library, far)])
        assert error_in_ulp(vector_function(function)(far), exact) <= 1
    large = np.array([709.0, 710.0, -800.0, 0.0, np.inf, -np.inf, 1.0, -1.0])
    found = vector_function(jnp.exp)(large)
    np.testing.assert_allclose(found, np.asarray(jnp.exp(large)), rtol=4e-16, atol=1e-300)


def test_what_is_no_number_stays_none():
    spoilt = np.array([np.nan, np.inf, -np.inf, 0, 0, 0, 0, 0])
    for function in (jnp.sin, jnp.cos):
        found = vector_function(function)(spoilt)
        np.testing.assert_array_equal(np.isnan(found), [True] * 3 + [False] * 5)
    assert np.isnan(vector_function(jnp.exp)(spoilt)[0])
