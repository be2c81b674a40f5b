"""Functions of JAX, read and printed, do what XLA does."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scalar_functions import FUNCTIONS, by_cc, by_llvm, read_function

from scdpr_jax.native.scalar.program import needed, operations

LANES = 8
POINTS = np.random.default_rng(7).uniform(-1, 1, (LANES, 3))
ROUNDINGS = 64 * np.finfo(float).eps
"""Some of the functions sum dozens of products of numbers around one."""


def printable(program):
    return replace(program, body=needed(program.body))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_what_is_printed_is_what_xla_computes(name):
    function = FUNCTIONS[name]
    program = printable(read_function(function, jnp.zeros(3)))
    expected = np.asarray(jax.vmap(function)(POINTS)).reshape(LANES, -1)
    vector, [scalar] = by_llvm(program, lanes=LANES)([POINTS])[0], [by_llvm(program, lanes=1)]
    compiled = by_cc(program)
    np.testing.assert_allclose(vector, expected, rtol=ROUNDINGS, atol=ROUNDINGS)
    for point, row in zip(POINTS, expected, strict=True):
        for run in (lambda own: scalar([own[None]])[0][0], lambda own: compiled([own])[0]):
            np.testing.assert_allclose(run(point), row, rtol=ROUNDINGS, atol=ROUNDINGS)


def test_nan_and_infinity_pass_as_in_xla():
    def function(x):
        return jnp.stack(
            [jnp.maximum(x[0], x[1]), jnp.minimum(x[0], x[1]), jnp.sign(x[0]), jnp.abs(x[1])]
        )

    program = printable(read_function(function, jnp.zeros(2)))
    special = [np.nan, np.inf, -np.inf, 1.0]
    for point in ([a, b] for a in special for b in special):
        expected = function(jnp.array(point))
        np.testing.assert_array_equal(by_cc(program)([np.array(point)])[0], expected)
        found = by_llvm(program, lanes=1)([np.array([point])])[0][0]
        np.testing.assert_array_equal(found, expected)


def test_a_neighbour_that_is_not_a_number_changes_no_bit():
    program = printable(read_function(FUNCTIONS["growth"], jnp.zeros(3)))
    run = by_llvm(program, lanes=LANES)
    spoilt = POINTS.copy()
    spoilt[3] = np.nan
    found, expected = run([spoilt])[0], run([POINTS])[0]
    assert np.all(np.isnan(found[3]))
    np.testing.assert_array_equal(np.delete(found, 3, 0), np.delete(expected, 3, 0))


def test_constants_are_folded_and_nothing_is_computed_twice():
    def function(x):
        two = jnp.sqrt(jnp.array(4.0))
        return (x * two + 0.0) * (x * two) / 1.0 - jnp.where(two > 1, 0.0, x)

    program = printable(read_function(function, jnp.zeros(())))
    names = [own.name for own in operations(program.body)]
    assert sorted(names) == ["mul", "mul", "read", "write"]


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda x: jnp.linalg.cholesky(jnp.outer(x, x)), "cholesky"),
        (lambda x: jax.lax.while_loop(lambda y: y[0] < 9, lambda y: y + 1, x), "while"),
        (lambda x: x[jnp.floor(x[0]).astype(int)], "convert_element_type"),
        (lambda x: jax.lax.scan(lambda y, z: (y + z, y), x[0], jnp.tile(x, 30))[1], "90 turns"),
    ],
)
def test_what_has_no_rule_is_named(function, message):
    with pytest.raises(NotImplementedError, match=message):
        read_function(function, jnp.ones(3))
