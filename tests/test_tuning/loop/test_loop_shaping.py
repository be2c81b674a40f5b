import functools

import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.command.controller import published_pd
from tuning.loop.loop_shaping import shape_loop, shape_sampled_loop
from tuning.loop.margins import continuous_margins, sampled_margins
from tuning.loop.plant import MotorPlant, published_plant
from tuning.loop.responses import continuous_loop, sampled_loop

PLANT = published_plant()
SIXTY = jnp.deg2rad(60.0)
EPS = float(jnp.finfo(PLANT.gain.dtype).eps)


def test_forty_radians_and_sixty_degrees_give_the_consistent_gains():
    controller = shape_loop(PLANT, crossover=40.0, phase_margin=SIXTY)
    # Given with five digits each.
    assert abs(per_degree(controller.proportional_gain) - 0.63523) <= 0.5e-5
    assert abs(per_degree(controller.derivative_gain) - 0.012126) <= 0.5e-6


def per_degree(gain):
    return float(gain) * float(jnp.pi) / 180


@jax.jit
def shaped(crossover, margin, filter_time):
    controller = shape_loop(
        PLANT, crossover=crossover, phase_margin=margin, filter_time=filter_time
    )
    return continuous_loop(PLANT, controller, crossover)


@functools.partial(jax.jit, static_argnames="delay")
def shaped_sampled(crossover, margin, delay):
    controller = shape_sampled_loop(
        PLANT, crossover=crossover, phase_margin=margin, delay=delay
    )
    return sampled_loop(PLANT, controller, crossover, delay=delay)


def distance_from_request(loop, margin):
    return abs(complex(loop) + np.exp(1j * float(margin)))


def test_published_gains_cross_over_at_another_frequency():
    margins = jax.jit(continuous_margins)(PLANT, published_pd())
    # Given with two decimals.
    assert abs(float(margins.gain_crossover) - 40.31) <= 0.005
    assert abs(float(jnp.rad2deg(margins.phase_margin)) - 60.90) <= 0.005


def test_published_gains_are_not_those_of_the_published_requirements():
    controller = shape_loop(PLANT, crossover=40.0, phase_margin=SIXTY)
    assert float(published_pd().derivative_gain / controller.derivative_gain) > 1.03


@hypothesis.given(
    crossover=st.floats(20, 200), degrees=st.floats(45, 85), filter_time=st.floats(0, 5e-4)
)
def test_shaped_loop_is_the_requested_phasor(crossover, degrees, filter_time):
    margin = jnp.deg2rad(degrees)
    loop = shaped(jnp.asarray(crossover), margin, jnp.asarray(filter_time))
    # Some ten roundings of terms up to a few times the result.
    assert distance_from_request(loop, margin) <= 64 * EPS


@hypothesis.given(
    crossover=st.floats(20, 200), degrees=st.floats(45, 60), delay=st.integers(0, 1)
)
def test_shaped_sampled_loop_is_the_requested_phasor(crossover, degrees, delay):
    margin = jnp.deg2rad(degrees)
    loop = shaped_sampled(jnp.asarray(crossover), margin, delay)
    # z - 1 keeps its digits: some twenty roundings of terms up to a few times the result.
    assert distance_from_request(loop, margin) <= 256 * EPS


def test_shaped_sampled_loop_has_the_requested_margins():
    controller = shape_sampled_loop(PLANT, crossover=40.0, phase_margin=SIXTY)
    margins = jax.jit(sampled_margins)(PLANT, controller)
    # The crossover is found by halving down to double precision, the phase follows.
    assert abs(float(margins.gain_crossover) / 40.0 - 1) <= 1e-12
    assert abs(float(margins.phase_margin - SIXTY)) <= 1e-12


def test_too_little_phase_margin_is_refused():
    with pytest.raises(ValueError, match=r"negative derivative gain needs more"):
        shape_loop(PLANT, crossover=40.0, phase_margin=0.1)


def test_too_much_phase_margin_is_refused():
    with pytest.raises(ValueError, match=r"150°, which need -"):
        shape_loop(PLANT, crossover=40.0, phase_margin=jnp.deg2rad(150.0))


def test_a_sampled_loop_refuses_what_its_delay_forbids():
    with pytest.raises(ValueError, match="must ask a PD controller for positive gains"):
        shape_sampled_loop(PLANT, crossover=1500.0, phase_margin=SIXTY)


def test_an_infeasible_request_has_no_gains_under_jit():
    design = jax.jit(lambda margin: shape_loop(PLANT, crossover=40.0, phase_margin=margin))
    assert jnp.isnan(design(jnp.asarray(0.1)).derivative_gain)
    assert jnp.isfinite(design(SIXTY).derivative_gain)


@pytest.mark.parametrize("design", [shape_loop, shape_sampled_loop])
def test_gains_are_differentiable_in_plant_and_request(design):
    def gains(gain, pole, crossover, margin):
        controller = design(
            MotorPlant(gain, pole), crossover=crossover, phase_margin=margin, period=0.01
        )
        return jnp.stack([controller.proportional_gain, controller.derivative_gain])

    arguments = tuple(jnp.asarray(value) for value in (3.0, 1.2, 4.0, 1.0))
    check_grads(jax.jit(gains), arguments, order=1, modes=("fwd", "rev"))


def test_requests_batch():
    crossovers = jnp.array([30.0, 40.0, 50.0])
    design = jax.vmap(lambda w: shape_loop(PLANT, crossover=w, phase_margin=SIXTY))
    one = shape_loop(PLANT, crossover=40.0, phase_margin=SIXTY)
    batch = jax.jit(design)(crossovers).derivative_gain[1]
    assert abs(float(batch / one.derivative_gain) - 1) <= 16 * EPS
