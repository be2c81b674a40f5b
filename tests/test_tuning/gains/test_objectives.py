import jax
import jax.numpy as jnp
from jax.test_util import check_grads

from tuning.gains.objectives import peak_to_peak, smooth_peak_to_peak, tracking_error

TIME = jnp.linspace(0.0, 1.0, 2001)
WINDOW = (TIME >= 0.5).astype(TIME.dtype)


def test_a_sinusoid_swings_twice_its_amplitude_peak_to_peak():
    signal = 3e-3 * jnp.sin(2 * jnp.pi * 10 * TIME)
    # The grid of 0.5 ms may miss each peak by half a step: (2π·10·0.25 ms)²/2 of it.
    tolerance = 6e-3 * (2 * jnp.pi * 10 * 0.25e-3) ** 2 / 2
    assert abs(float(peak_to_peak(signal, WINDOW)) - 6e-3) <= tolerance


def test_the_smooth_surrogate_of_a_sinusoid_is_its_mean_of_eighth_order():
    signal = 1.0 + 3e-3 * jnp.sin(2 * jnp.pi * 10 * TIME)
    # The mean of sin^8 is 35/128; the window's end counts one sample of 1001 twice.
    expected = 6e-3 * (35 / 128) ** 0.125
    assert abs(float(smooth_peak_to_peak(signal, WINDOW)) / expected - 1) <= 2e-3


def test_what_happens_before_the_window_does_not_count():
    signal = jnp.where(TIME < 0.5, 1.0, 0.0)
    assert float(peak_to_peak(signal, WINDOW)) == 0
    assert float(smooth_peak_to_peak(signal, WINDOW)) == 0


def test_a_signal_at_rest_has_a_surrogate_with_a_finite_gradient():
    gradient = jax.grad(lambda s: smooth_peak_to_peak(s, WINDOW))(jnp.zeros_like(TIME))
    assert jnp.all(jnp.isfinite(gradient))


def test_the_surrogate_is_differentiable_in_both_modes():
    def swing(amplitude):
        return smooth_peak_to_peak(amplitude * jnp.sin(20 * TIME) + TIME, WINDOW)

    check_grads(jax.jit(swing), (0.3,), order=1, modes=("fwd", "rev"))


def test_the_error_of_eq_26_is_the_distance_to_the_reference():
    error = tracking_error(jnp.array([[0.0, 0.0]]), jnp.array([[3.0, 4.0]]))
    assert float(error[0]) == 5


def test_the_error_of_eq_26_has_a_finite_gradient_on_the_reference():
    place = jnp.zeros((1, 2))
    assert jnp.all(jax.grad(lambda p: jnp.sum(tracking_error(p, place)))(place) == 0)
