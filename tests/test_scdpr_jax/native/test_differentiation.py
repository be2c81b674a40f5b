"""Tangents by rules on the scalar program are JAX's, at kinks too, in any number."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scalar_functions import FUNCTIONS, by_cc, by_llvm, read_function

from scdpr_jax.native.scalar.differentiation import differentiated
from scdpr_jax.native.scalar.elementary import vectorised
from scdpr_jax.native.scalar.program import needed, operations
from scdpr_jax.native.scalar.tangent_loops import loop_over_tangents

LANES, TANGENTS = 8, 5
RANDOM = np.random.default_rng(11)
POINTS = RANDOM.uniform(-1, 1, (LANES, 3))
SEEDS = RANDOM.uniform(-1, 1, (LANES, TANGENTS, 3))
ROUNDINGS = 256 * np.finfo(float).eps
"""Derivatives of sums of dozens of products, up to some ten in size."""


def derived(function, size):
    program = differentiated(
        read_function(function, jnp.zeros(size), chains=True), ["parameter0"]
    )
    return replace(program, body=needed(program.body))


def expected(function, points, seeds):
    def along(point, seed):
        return jax.jvp(function, (point,), (seed,))

    values, slopes = jax.vmap(jax.vmap(along, (None, 0), (None, 0)))(points, seeds)
    return (
        np.asarray(values).reshape(len(points), -1),
        np.asarray(slopes).reshape(len(points), seeds.shape[1], -1),
    )


@pytest.mark.parametrize("name", FUNCTIONS)
def test_tangents_are_those_of_jax(name):
    program = derived(FUNCTIONS[name], 3)
    wanted = expected(FUNCTIONS[name], POINTS, SEEDS)
    vector = by_llvm(loop_over_tangents(vectorised(program)), lanes=LANES)
    compiled = by_cc(loop_over_tangents(program))
    for found, own in zip(vector([POINTS, SEEDS], TANGENTS), wanted, strict=True):
        np.testing.assert_allclose(found, own, rtol=ROUNDINGS, atol=ROUNDINGS)
    for i in range(LANES):
        for found, own in zip(compiled([POINTS[i], SEEDS[i]], TANGENTS), wanted, strict=True):
            np.testing.assert_allclose(found, own[i], rtol=ROUNDINGS, atol=ROUNDINGS)


@pytest.mark.parametrize(
    "function",
    [
        jnp.abs,
        jnp.sign,
        lambda x: jnp.maximum(x, 0.0),
        lambda x: jnp.minimum(x, x[::-1]),
        lambda x: jnp.clip(x, 0.0, 1.0),
        lambda x: jax.lax.clamp(-1.0, x, 0.0),
        lambda x: jnp.where(x > 0, jnp.sqrt(jnp.where(x > 0, x, 1.0)), 0.0),
        lambda x: jnp.where(x > 0, jnp.sqrt(x), x),
        lambda x: jnp.where(x > 0, 3 * jnp.log(jnp.sin(x) * 2 * jnp.sqrt(x)), x),
        lambda x: jnp.where(jnp.abs(x) <= 1, x, jnp.sign(x)),
        jnp.square,
        lambda x: x**3,
    ],
)
def test_at_kinks_they_are_those_of_jax_too(function):
    points = np.array([[0.0, 0.0], [1.0, 1.0], [-1.0, 0.0], [0.5, -0.5]])
    seeds = RANDOM.uniform(-1, 1, (4, 1, 2))
    run = by_llvm(loop_over_tangents(derived(function, 2)), lanes=4)
    for found, own in zip(run([points, seeds]), expected(function, points, seeds), strict=True):
        np.testing.assert_allclose(found, own, rtol=4 * np.finfo(float).eps, atol=0)


def test_what_does_not_move_costs_nothing():
    program = read_function(
        lambda x, y: jnp.exp(jnp.sin(y)) * x, jnp.zeros(()), jnp.zeros(()), chains=True
    )
    pushed = differentiated(program, ["parameter0"])
    more = len(operations(needed(pushed.body))) - len(operations(needed(program.body)))
    assert more == len(["read the tangent", "multiply it", "write it"])


def test_the_code_is_as_long_for_many_tangents_as_for_one():
    program = loop_over_tangents(derived(FUNCTIONS["counting"], 3))
    run = by_llvm(program, lanes=LANES)
    for tangents in (1, 3, 16):
        seeds = RANDOM.uniform(-1, 1, (LANES, tangents, 3))
        _, wanted = expected(FUNCTIONS["counting"], POINTS, seeds)
        _, found = run([POINTS, seeds], tangents)
        np.testing.assert_allclose(found, wanted, rtol=ROUNDINGS, atol=ROUNDINGS)
