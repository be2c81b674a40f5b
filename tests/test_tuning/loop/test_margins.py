import control
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.signal
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.command.controller import PD, published_pd
from tuning.loop.margins import continuous_margins, sampled_margins
from tuning.loop.plant import MotorPlant, published_plant

PLANT = published_plant()
PERIOD = 1e-3
SLOW = PD(36.0, 0.5, 0.01, 0.005)

continuous = jax.jit(continuous_margins)
sampled = jax.jit(sampled_margins, static_argnames="delay")


def polynomials(controller, delay):
    """Numerator and denominator of the open loop in z, by an independent discretisation."""
    period, filter_time = float(controller.period), float(controller.filter_time)
    gain, slope = float(controller.proportional_gain), float(controller.derivative_gain)
    total = period + filter_time
    plant = ([float(PLANT.gain)], [1, float(PLANT.pole), 0])
    numerator, denominator, _ = scipy.signal.cont2discrete(plant, period, method="zoh")
    numerator = np.convolve(numerator[0], [gain * total + slope, -gain * filter_time - slope])
    denominator = np.convolve(denominator, [total, -filter_time])
    return numerator, np.concatenate([denominator, np.zeros(delay)])


def spectral_radius(controller, delay, factor):
    numerator, denominator = polynomials(controller, delay)
    return np.max(np.abs(np.roots(np.polyadd(factor * numerator, denominator))))


@pytest.mark.parametrize("controller", [published_pd(), PD(36.4, 0.7, PERIOD, 2e-3)])
def test_continuous_margins_are_those_of_python_control(controller):
    gain, slope = float(controller.proportional_gain), float(controller.derivative_gain)
    tau = float(controller.filter_time)
    pd = control.tf([gain * tau + slope, gain], [tau, 1])
    loop = pd * control.tf([float(PLANT.gain)], [1, float(PLANT.pole), 0])
    _, phase, _, _, crossover, _ = control.stability_margins(loop)
    margins = continuous(PLANT, controller)
    # Its crossover comes from the roots of a polynomial: ten digits.
    assert abs(float(margins.gain_crossover) / crossover - 1) <= 1e-9
    assert abs(float(jnp.rad2deg(margins.phase_margin)) - phase) <= 1e-7


@pytest.mark.parametrize("delay", [0, 1])
@pytest.mark.parametrize("controller", [published_pd(), SLOW], ids=["published", "slow"])
def test_sampled_margins_are_those_of_python_control(controller, delay):
    loop = control.tf(*polynomials(controller, delay), float(controller.period))
    found = control.stability_margins(loop, method="frd")
    gain, phase, _, phase_crossover, crossover, _ = found
    margins = sampled(PLANT, controller, delay=delay)
    # Its polynomials of z cancel near 1, where they keep six digits and more.
    assert abs(float(margins.gain_crossover) / crossover - 1) <= 1e-5
    assert abs(float(jnp.rad2deg(margins.phase_margin)) - phase) <= 1e-3
    assert abs(float(margins.gain_margin) / gain - 1) <= 1e-5
    assert abs(float(margins.phase_crossover) / phase_crossover - 1) <= 1e-5


@hypothesis.settings(max_examples=50)
@hypothesis.given(
    proportional_gain=st.floats(1, 100),
    derivative_share=st.floats(5e-3, 0.05),
    filter_periods=st.floats(0, 3),
    delay=st.integers(0, 1),
)
def test_gain_margin_is_where_the_sampled_loop_turns_unstable(
    proportional_gain, derivative_share, filter_periods, delay
):
    derivative_gain = proportional_gain * derivative_share
    controller = PD(proportional_gain, derivative_gain, PERIOD, filter_periods * PERIOD)
    margin = float(sampled(PLANT, controller, delay=delay).gain_margin)
    assert spectral_radius(controller, delay, 0.999 * margin) < 1
    assert spectral_radius(controller, delay, 1.001 * margin) > 1


def test_gain_margin_is_found_at_the_nyquist_frequency():
    # A plant so fast that it only integrates: the hold's lag is 90° at the Nyquist frequency.
    period, plant = 0.05, MotorPlant(1000.0, 1000.0)
    margins = sampled(plant, PD(1.0, 0.0, period), delay=0)
    # z = -1 in g h^2 (phi_2 z + phi_1 - phi_2) / ((z - 1)(z - e^{-x})), x = 50.
    first, second = 1 / 50, 49 / 50**2
    value = 1000.0 * period**2 * (first - 2 * second) / 2
    assert abs(float(margins.phase_crossover) * period / np.pi - 1) <= 1e-12
    assert abs(float(margins.gain_margin) * abs(value) - 1) <= 1e-12


def test_delay_margin_falls_by_a_period_with_a_sample():
    before = sampled(PLANT, published_pd(), delay=0)
    after = sampled(PLANT, published_pd(), delay=1)
    # A delay doesn't move the gain crossover.
    difference = float(before.delay_margin - after.delay_margin)
    assert abs(difference - PERIOD) <= 1e-12


def test_delay_margin_is_where_the_sampled_loop_turns_unstable():
    margin = float(sampled(PLANT, published_pd(), delay=0).delay_margin)
    spare = int(margin / PERIOD)
    assert spectral_radius(published_pd(), spare, 1.0) < 1
    assert spectral_radius(published_pd(), spare + 1, 1.0) > 1


def test_more_than_a_turn_of_lag_is_no_positive_margin():
    # 180 samples add 7.2 rad of lag at the crossover.
    assert sampled(PLANT, published_pd(), delay=180).phase_margin < -2 * np.pi + 1.1


@pytest.mark.parametrize("delay", [0, 1])
def test_peak_sensitivity_is_that_of_a_dense_sweep(delay):
    z = np.exp(1j * PERIOD * np.linspace(1.0, np.pi / PERIOD, 200_001))
    numerator, denominator = (
        np.polyval(part, z) for part in polynomials(published_pd(), delay)
    )
    peak = np.max(np.abs(denominator / (denominator + numerator)))
    got = float(sampled(PLANT, published_pd(), delay=delay).peak_sensitivity)
    # Steps of 0.016 rad/s at a peak some 100 rad/s wide: the square of their ratio.
    assert abs(got / peak - 1) <= 1e-6


def test_continuous_peak_sensitivity_is_that_of_a_dense_sweep():
    s = 1j * np.geomspace(1e-1, 1e4, 200_001)
    controller = published_pd()
    pd = float(controller.proportional_gain) + float(controller.derivative_gain) * s
    loop = pd * float(PLANT.gain) / (s * (s + float(PLANT.pole)))
    got = float(continuous(PLANT, controller).peak_sensitivity)
    # Steps of 6e-5 of the frequency, squared, with room.
    assert abs(got / np.max(1 / np.abs(1 + loop)) - 1) <= 1e-6


def test_continuous_gain_margin_is_infinite():
    margins = continuous(PLANT, published_pd())
    assert jnp.isinf(margins.gain_margin)
    assert jnp.isnan(margins.phase_crossover)


def test_sampling_costs_the_published_loop_its_two_lags_of_phase():
    loss = (
        continuous(PLANT, published_pd()).phase_margin
        - sampled(PLANT, published_pd(), delay=1).phase_margin
    )
    # At 40.3 rad/s: a sample of delay and half of the hold, 60.5 mrad, and the backward
    # difference's own half sample, weighted with the derivative's share of the command.
    assert 0.0605 < float(loss) < 2 * 0.0403


def test_no_crossover_below_the_nyquist_frequency_is_nan():
    # Far more gain than a loop of 1 kHz can run with.
    margins = sampled(PLANT, PD(1e7, 1e5), delay=1)
    assert jnp.isnan(margins.gain_crossover)
    assert jnp.isnan(margins.phase_margin)


def test_a_negative_delay_is_refused():
    with pytest.raises(ValueError, match="`delay` must not be negative"):
        sampled_margins(PLANT, published_pd(), delay=-1)


@pytest.mark.slow
def test_margins_are_differentiable_in_plant_and_controller():
    def margins(gain, pole, proportional, derivative, filter_time):
        controller = PD(proportional, derivative, 0.05, filter_time)
        found = sampled_margins(MotorPlant(gain, pole), controller)
        return jnp.stack(jax.tree.leaves(found))

    arguments = tuple(jnp.asarray(value) for value in (2.0, 1.3, 3.0, 1.1, 0.5))
    check_grads(jax.jit(margins), arguments, order=1, modes=("fwd", "rev"))


@pytest.mark.slow
def test_continuous_margins_are_differentiable_in_the_gains():
    def margins(proportional, derivative):
        found = continuous_margins(MotorPlant(2.0, 1.3), PD(proportional, derivative))
        return jnp.stack([found.gain_crossover, found.phase_margin, found.peak_sensitivity])

    arguments = (jnp.asarray(3.0), jnp.asarray(0.3))
    check_grads(jax.jit(margins), arguments, order=1, modes=("fwd", "rev"))


def test_an_infinite_gain_margin_has_zero_derivative():
    slope = jax.grad(lambda gain: continuous_margins(PLANT, PD(gain, 0.7)).gain_margin)
    assert jax.jit(slope)(jnp.asarray(36.0)) == 0


def test_margins_batch_over_gains():
    gains = jnp.array([30.0, 36.0, 42.0])
    batch = jax.jit(jax.vmap(lambda gain: sampled_margins(PLANT, PD(gain, 0.7))))(gains)
    one = sampled(PLANT, PD(gains[1], 0.7))
    # The same halvings, fused otherwise.
    assert abs(float(batch.gain_margin[1] / one.gain_margin) - 1) <= 1e-12


@pytest.mark.slow
def test_margins_hold_in_single_precision():
    plant, controller = jax.tree.map(
        lambda leaf: leaf.astype(jnp.float32), (PLANT, published_pd())
    )
    single, double = sampled(plant, controller), sampled(PLANT, published_pd())
    # A few digits less than the seven of the type.
    assert abs(float(single.phase_margin) - float(double.phase_margin)) <= 1e-5
    assert abs(float(single.gain_margin) / float(double.gain_margin) - 1) <= 1e-4
