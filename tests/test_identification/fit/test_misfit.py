import hypothesis
import hypothesis.strategies as st
import jax
import jax.numpy as jnp
import numpy as np

from identification.fit.misfit import NOISE, channel_misfit

COUNT, DURATION = 200, 2.0


def misfit(scale, samples=COUNT, duration=DURATION):
    residual = jnp.full((samples, 1), scale)
    return channel_misfit(residual, jnp.array([float(samples)]), jnp.array(duration))


@hypothesis.given(st.floats(0.0, float(np.sqrt(NOISE)) * 0.999))
def test_noise_counts_as_least_squares(scale):
    found = misfit(scale)
    # Summing 200 equal squares rounds each of them.
    np.testing.assert_allclose(found.cost, COUNT * scale**2, rtol=1e-12)
    np.testing.assert_array_equal(found.weight, 1.0)


@hypothesis.given(st.floats(0.1, 1e4))
def test_the_weight_is_the_slope_over_that_of_least_squares(scale):
    hypothesis.assume(abs(scale**2 - NOISE) > 1e-3)
    slope = jax.grad(lambda s: jnp.sum(misfit(s).cost))(jnp.asarray(scale))
    np.testing.assert_allclose(misfit(scale).weight * 2 * COUNT * scale, slope, rtol=1e-9)


def test_it_grows_without_a_jump_or_a_kink():
    edge = np.sqrt(NOISE)
    below, above = misfit(edge * (1 - 1e-9)), misfit(edge * (1 + 1e-9))
    # A relative step of 1e-9 changes the cost by 4e-9 of itself, the weight by 3e-8.
    np.testing.assert_allclose(below.cost, above.cost, rtol=1e-8)
    np.testing.assert_allclose(below.weight, above.weight, rtol=1e-6)


def test_an_erring_model_is_judged_by_time_not_by_samples():
    fast = misfit(1e3, samples=2000)
    slow = misfit(1e3, samples=60)
    # Both last 2 s: twenty stretches of 0.1 s whatever the rate, up to the logarithm of it.
    assert 0.5 < float((fast.cost / slow.cost)[0] / (2000 / 60)) * (2000 / 60) < 40
    information = [float(f.weight[0]) * n for f, n in ((fast, 2000), (slow, 60))]
    np.testing.assert_allclose(information[0], information[1], rtol=0.05)
