"""Tangents' operations are fewer where slopes are multiplied out before."""

import collections
from dataclasses import replace

import jax
import jax.numpy as jnp
import pytest
from scalar_functions import FUNCTIONS, read_function

from scdpr_jax.native.scalar import tangent_loops
from scdpr_jax.native.scalar.differentiation import differentiated
from scdpr_jax.native.scalar.program import Each, needed, operations, statements
from scdpr_jax.native.scalar.scope import ZERO
from scdpr_jax.native.scalar.tangent_loops import loop_over_tangents


def work(function, size=3):
    """What each tangent costs: a product with a sum is one operation, moving numbers none."""
    read = read_function(function, jnp.zeros(size), chains=True)
    program = differentiated(read, ["parameter0"])
    program = loop_over_tangents(replace(program, body=needed(program.body)))
    loops = [own for own in statements(program.body) if isinstance(own, Each)]
    every = [own for loop in loops for own in operations(loop.body)]
    uses = collections.Counter(source for own in every for source in own.sources)
    fused = {own.target for own in every if own.name == "mul" and uses[own.target] == 1}
    return sum(
        own.name not in ("read", "write")
        and ZERO not in own.sources
        and not (own.name in ("add", "sub") and not fused.isdisjoint(own.sources))
        for own in every
    )


def test_a_chain_is_one_product():
    def chain(x):
        return jnp.exp(jnp.sin(jnp.tanh(jnp.exp(jnp.cos(x[0] * 2)))))

    assert work(chain) == 1


def test_a_narrow_waist_stays():
    def waist(x):
        # Seven terms of a sum and ten products of it are fewer than seventy around it.
        return jnp.sin(jnp.sum(jnp.square(x))) * jnp.arange(1.0, 11.0)

    assert work(waist, 7) == 7 + 10


@pytest.mark.parametrize("name", FUNCTIONS)
def test_no_function_gets_dearer(name, monkeypatch):
    short = work(FUNCTIONS[name])
    monkeypatch.setattr(tangent_loops, "eliminated", lambda block, _: block)
    assert short <= work(FUNCTIONS[name])


def test_of_a_step_that_rests_in_no_branch_half_is_left(monkeypatch):
    def long(x):
        for _ in range(20):
            x = jnp.sin(x @ jnp.ones((3, 3))) + x / (1 + x * x) * jax.nn.sigmoid(x)
        return x

    short = work(long)
    monkeypatch.setattr(tangent_loops, "eliminated", lambda block, _: block)
    assert short < 0.5 * work(long)
