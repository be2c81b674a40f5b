import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.command.controller import PD, published_pd
from tuning.loop.plant import published_plant
from tuning.loop.responses import (
    continuous_derivative,
    continuous_loop,
    sampled_delay,
    sampled_derivative,
    sampled_loop,
)

PLANT = published_plant()
FILTERED = PD(36.0, 0.7, 1e-3, 2e-3)
EPS = float(np.finfo(float).eps)


@pytest.mark.parametrize("filter_time", [0.0, 2e-3])
def test_sampled_derivative_is_that_of_the_running_controller(filter_time):
    controller = PD(0.0, 1.0, 1e-3, filter_time)
    frequency, count = 150.0, 400
    phases = frequency * 1e-3 * np.arange(count)
    errors = jnp.asarray(np.stack([np.cos(phases), np.sin(phases)], axis=1))

    def step(state, error):
        return controller.step(state, error, jnp.zeros(2))

    state = controller.initial_state(errors[0], jnp.zeros(2))
    outputs = jax.lax.scan(step, state, errors)[1]
    # Cosine and sine are the two parts of one rotating phasor.
    measured = complex(*outputs[-1]) / complex(*errors[-1])
    expected = sampled_derivative(
        jnp.asarray(frequency), period=jnp.asarray(1e-3), filter_time=jnp.asarray(filter_time)
    )
    # The transient is gone: (2/3)^400; differences over 1 ms lose three digits.
    assert abs(measured - complex(expected)) <= 1e-9


def test_sampled_derivative_tends_to_the_continuous_one():
    frequency, filter_time = jnp.asarray(30.0), jnp.asarray(5e-3)
    fine = sampled_derivative(frequency, period=jnp.asarray(1e-7), filter_time=filter_time)
    exact = continuous_derivative(frequency, filter_time=filter_time)
    # First order in the period: half of w² h.
    assert abs(complex(fine - exact)) <= 30.0**2 * 1e-7


def test_a_delay_of_a_sample_turns_by_its_angle():
    turned = sampled_delay(jnp.asarray(100.0), period=jnp.asarray(1e-3), delay=2)
    assert abs(complex(turned) - np.exp(-0.2j)) <= 4 * EPS


@pytest.mark.parametrize("controller", [published_pd(), FILTERED])
def test_sampled_loop_tends_to_the_continuous_one(controller):
    fast = PD(
        controller.proportional_gain, controller.derivative_gain, 1e-6, controller.filter_time
    )
    frequency = jnp.asarray(40.0)
    ratio = sampled_loop(PLANT, fast, frequency) / continuous_loop(PLANT, fast, frequency)
    # Two periods of lag at most: 40 * 2e-6.
    assert abs(complex(ratio) - 1) <= 2 * 40e-6
