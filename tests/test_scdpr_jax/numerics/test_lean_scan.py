"""A scan whose reverse mode keeps no more than what it carries."""

import jax
import jax.numpy as jnp
import numpy as np

from scdpr_jax.numerics.lean_scan import lean_scan

STEPS, LANES = 1000, 8


def far(scan):
    """A function of 8 numbers, by steps that compute much from them."""

    def step(carry, push):
        for _ in range(20):
            carry = jnp.sin(carry) + push
        return carry, carry

    def end(start):
        last, rows = scan(step, start, jnp.linspace(0.0, 0.1, STEPS))
        return jnp.sum(last) + jnp.sum(rows)

    return end


def test_values_and_gradients_are_those_of_a_plain_scan():
    start = jnp.linspace(-1.0, 1.0, LANES)
    found = jax.value_and_grad(far(lean_scan))(start)
    expected = jax.value_and_grad(far(jax.lax.scan))(start)
    # Each step may be fused in another way.
    np.testing.assert_allclose(found[0], expected[0], rtol=1e-14)
    np.testing.assert_allclose(found[1], expected[1], rtol=1e-12)


def test_reverse_mode_keeps_what_is_carried_and_nothing_else():
    def kept(scan):
        compiled = jax.jit(jax.grad(far(scan))).lower(jnp.zeros(LANES)).compile()
        return compiled.memory_analysis().temp_size_in_bytes

    row = STEPS * LANES * 8
    assert kept(jax.lax.scan) > 15 * row
    assert kept(lean_scan) < 4 * row
