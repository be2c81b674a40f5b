import control
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st
from jax.test_util import check_grads

from tuning.loop.plant import MotorPlant, continuous_response, published_plant, sampled_response

PLANT = published_plant()
PERIOD = jnp.asarray(1e-3)
EPS = float(np.finfo(float).eps)
FREQUENCIES = jnp.asarray(np.geomspace(1e-2, np.pi / 1e-3, 40))

pole = st.floats(0, 500)
period = st.floats(1e-4, 0.05)


@jax.jit
def continuous(plant, frequencies):
    return jax.vmap(lambda w: continuous_response(plant, w))(frequencies)


@jax.jit
def sampled(plant, frequencies, period):
    return jax.vmap(lambda w: sampled_response(plant, w, period=period))(frequencies)


def relative(got, expected):
    return np.max(np.abs(np.asarray(got) / np.asarray(expected) - 1))


def test_published_gain_is_the_drive_chain_over_its_inertia():
    # k_v = 0.482 N m/V has three digits, half a unit of the third is 0.1 %.
    assert abs(float(PLANT.gain) / (0.482 / 1.2734e-2) - 1) <= 1e-3


def test_continuous_response_is_the_transfer_function():
    system = control.tf([float(PLANT.gain)], [1, float(PLANT.pole), 0])
    assert (
        relative(continuous(PLANT, FREQUENCIES), system(1j * np.asarray(FREQUENCIES))) <= 1e-14
    )


def test_sampled_response_is_that_of_the_zero_order_hold():
    system = control.tf([float(PLANT.gain)], [1, float(PLANT.pole), 0])
    reference = control.sample_system(system, 1e-3, method="zoh")
    expected = reference(np.exp(1j * np.asarray(FREQUENCIES) * 1e-3))
    # The reference's denominator (z - 1)(z - e^{-x}) is summed up from terms of 1: at
    # 0.01 rad/s it is 1e-5 * 0.017, and eps / 1.7e-7 is 1.3e-9, for each of its roundings.
    assert relative(sampled(PLANT, FREQUENCIES, PERIOD), expected) <= 1e-8


@hypothesis.given(pole=pole, period=period, share=st.floats(1e-3, 1))
def test_sampled_response_is_the_sum_of_the_aliases_of_its_closed_form(pole, period, share):
    # The zero-order hold's response, summed over the aliases that a sampler folds down.
    frequency = share * np.pi / period
    aliased = frequency + 2 * np.pi / period * np.arange(-4000, 4001)
    s = 1j * aliased
    # 1 - e^{-sh} is the same for every alias.
    hold = (1 - np.exp(-1j * frequency * period)) / (s * period)
    expected = np.sum(hold / (s * (s + pole)))
    got = sampled(MotorPlant(1.0, pole), jnp.array([frequency]), jnp.asarray(period))[0]
    # The tail falls as the cube: 4000^-3 and less of the plant's own response, to which the
    # sum is compared because it vanishes at the Nyquist frequency without damping.
    scale = abs(1 / (1j * frequency * (1j * frequency + pole)))
    assert abs(complex(got) - expected) <= 1e-10 * scale


def test_sampled_response_tends_to_a_double_integrator_without_damping():
    got = sampled(MotorPlant(3.0, 0.0), FREQUENCIES, PERIOD)
    z = np.exp(1j * np.asarray(FREQUENCIES) * 1e-3)
    # At 0.01 rad/s the square of z - 1 in the reference keeps nine digits.
    assert relative(got, 3.0 * 1e-6 / 2 * (z + 1) / (z - 1) ** 2) <= 1e-8


@pytest.mark.parametrize("x", [0.1 * (1 - 1e-9), 0.1 * (1 + 1e-9)])
def test_sampled_response_is_continuous_where_the_series_ends(x):
    response = sampled_response(MotorPlant(1.0, x), jnp.asarray(1.0), period=jnp.asarray(1.0))
    middle = sampled_response(MotorPlant(1.0, 0.1), jnp.asarray(1.0), period=jnp.asarray(1.0))
    # The step itself, beside ten digits that the closed form loses at 0.1 at most.
    assert abs(complex(response) - complex(middle)) <= 1e-9


def test_sampled_response_loses_half_a_period_against_the_continuous_one():
    got = sampled(PLANT, jnp.array([40.0]), PERIOD)
    lag = np.angle(complex((got / continuous(PLANT, jnp.array([40.0])))[0]))
    # The hold's half period; corrections are of the third order in w h = 0.04.
    assert abs(lag + 0.5 * 40e-3) <= 0.04**3


@pytest.mark.parametrize("pole", [0.0, 30.0])  # on either side of the series' end
def test_responses_are_differentiable_in_plant_frequency_and_period(pole):
    def parts(gain, pole, frequency, period):
        plant = MotorPlant(gain, pole)
        one = continuous_response(plant, frequency)
        two = sampled_response(plant, frequency, period=period)
        return jnp.stack([one.real, one.imag, two.real, two.imag])

    arguments = tuple(jnp.asarray(value) for value in (2.0, pole, 3.0, 0.1))
    check_grads(jax.jit(parts), arguments, order=1, modes=("fwd", "rev"))
