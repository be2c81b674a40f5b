r"""PD gains from a gain crossover and a phase margin, in closed form, section 6.1.

The open loop is to be $L = e^{j(\varphi_m - \pi)}$ at the crossover. This is one complex
equation, linear in the two gains.
"""

import functools
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Complex, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.robot.fields import measured, real, refuse
from tuning.loop.plant import MotorPlant, continuous_response, imaginary, sampled_response
from tuning.loop.responses import continuous_derivative, sampled_delay, sampled_derivative


def shape_loop(
    plant: MotorPlant,
    *,
    crossover: Any,
    phase_margin: Any,
    period: Any = 1e-3,
    filter_time: Any = 0.0,
) -> PD:
    r"""PD gains for a continuous loop, as Eq. (25) was found.

    Without a filter

    $$ K_p = \frac{\omega_c}{g} (\omega_c \cos\varphi_m + p \sin\varphi_m), \qquad
       K_d = \frac{1}{g} (\omega_c \sin\varphi_m - p \cos\varphi_m) $$

    The sampled loop that runs these gains has less phase: see `tuning.loop.margins`.

    Args:
        plant: The drive.
        crossover: Gain crossover $\omega_c$ [rad/s].
        phase_margin: Phase margin $\varphi_m$ [rad].
        period: Sample period that the controller will run at [s]; doesn't change the gains.
        filter_time: Time constant of the derivative's filter [s].

    Returns:
        The controller.

    Raises:
        ValueError: If the request asks for a negative gain; under `jit` the gains are NaN.
    """
    crossover, phase_margin = real(crossover), real(phase_margin)
    filter_time = real(filter_time)
    gains = _continuous_gains(plant, crossover, phase_margin, filter_time)
    return PD(*_feasible(*gains, crossover, phase_margin), period, filter_time)


def shape_sampled_loop(
    plant: MotorPlant,
    *,
    crossover: Any,
    phase_margin: Any,
    period: Any = 1e-3,
    filter_time: Any = 0.0,
    delay: int = 1,
) -> PD:
    r"""PD gains for the loop as the controller runs it, exactly.

    The plant sits behind a zero-order hold, the derivative is a backward difference, and the
    command comes some samples late.

    Args:
        plant: The drive.
        crossover: Gain crossover $\omega_c$ of the sampled loop [rad/s].
        phase_margin: Phase margin $\varphi_m$ of the sampled loop [rad].
        period: Sample period [s].
        filter_time: Time constant of the derivative's filter [s].
        delay: Samples from a measurement to its command.

    Returns:
        The controller.

    Raises:
        ValueError: If the request asks for a negative gain; under `jit` the gains are NaN.
    """
    crossover, phase_margin = real(crossover), real(phase_margin)
    period, filter_time = real(period), real(filter_time)
    gains = _sampled_gains(plant, crossover, phase_margin, period, delay, filter_time)
    return PD(*_feasible(*gains, crossover, phase_margin), period, filter_time)


@jax.jit
def _continuous_gains(
    plant: MotorPlant,
    crossover: Float[Array, ""],
    phase_margin: Float[Array, ""],
    filter_time: Float[Array, ""],
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    response = continuous_response(plant, crossover)
    derivative = continuous_derivative(crossover, filter_time=filter_time)
    return _gains(response, derivative, phase_margin)


@functools.partial(jax.jit, static_argnames="delay")
def _sampled_gains(
    plant: MotorPlant,
    crossover: Float[Array, ""],
    phase_margin: Float[Array, ""],
    period: Float[Array, ""],
    delay: int,
    filter_time: Float[Array, ""],
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    lag = sampled_delay(crossover, period=period, delay=delay)
    response = lag * sampled_response(plant, crossover, period=period)
    derivative = sampled_derivative(crossover, period=period, filter_time=filter_time)
    return _gains(response, derivative, phase_margin)


def _gains(
    response: Complex[Array, ""], derivative: Complex[Array, ""], phase_margin: Float[Array, ""]
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    r"""The gains of $(K_p + K_d D) G = e^{j(\varphi_m - \pi)}$."""
    target = -jnp.exp(imaginary(phase_margin)) / response
    derivative_gain = jnp.imag(target) / jnp.imag(derivative)
    return jnp.real(target) - derivative_gain * jnp.real(derivative), derivative_gain


def _feasible(
    proportional_gain: Float[Array, ""],
    derivative_gain: Float[Array, ""],
    crossover: Float[Array, ""],
    phase_margin: Float[Array, ""],
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    feasible = (crossover > 0) & (proportional_gain > 0) & (derivative_gain >= 0)
    degrees = measured(jnp.rad2deg(phase_margin), "1")
    message = (
        "`crossover` and `phase_margin` must ask a PD controller for positive gains, got "
        f"{measured(crossover, 'rad/s')} and {degrees}°, which need "
        f"{measured(proportional_gain, 'V/rad')} and {measured(derivative_gain, 'V s/rad')}: a "
        "negative derivative gain needs more of either, a negative proportional gain less "
        "phase margin or a shorter filter."
    )
    return refuse((proportional_gain, derivative_gain), ~feasible, message)
