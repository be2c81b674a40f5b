"""Frequency responses of a PD controller's parts, continuous and sampled."""

import jax.numpy as jnp
from jaxtyping import Array, Complex, Float

from scdpr_jax.command.controller import PD
from tuning.loop.plant import (
    MotorPlant,
    as_complex,
    continuous_response,
    imaginary,
    sampled_response,
    shift_minus_one,
)


def continuous_derivative(
    angular_frequency: Float[Array, ""], *, filter_time: Float[Array, ""]
) -> Complex[Array, ""]:
    r"""The filtered derivative, $s / (1 + \tau s)$ at $s = j\omega$.

    Args:
        angular_frequency: $\omega$ [rad/s].
        filter_time: Time constant $\tau$ of the filter [s].

    Returns:
        Response [1/s].
    """
    s = imaginary(angular_frequency)
    (filter_time,) = as_complex(filter_time)
    return s / (1 + filter_time * s)


def sampled_derivative(
    angular_frequency: Float[Array, ""],
    *,
    period: Float[Array, ""],
    filter_time: Float[Array, ""],
) -> Complex[Array, ""]:
    r"""The filtered backward difference of `scdpr_jax.command.controller.PD`.

    At $z = e^{j\omega h}$:

    $$ D(z) = \frac{1 - z^{-1}}{h + \tau (1 - z^{-1})} $$

    Args:
        angular_frequency: $\omega$ [rad/s].
        period: Sample period $h$ [s].
        filter_time: Time constant $\tau$ of the filter [s].

    Returns:
        Response [1/s].
    """
    difference = -shift_minus_one(-angular_frequency * period)
    period, filter_time = as_complex(period, filter_time)
    return difference / (period + filter_time * difference)


def sampled_delay(
    angular_frequency: Float[Array, ""], *, period: Float[Array, ""], delay: int
) -> Complex[Array, ""]:
    r"""A delay of whole samples, $z^{-d}$.

    Args:
        angular_frequency: $\omega$ [rad/s].
        period: Sample period [s].
        delay: Samples $d$.

    Returns:
        Response [1].
    """
    return jnp.exp(imaginary(-delay * angular_frequency * period))


def continuous_loop(
    plant: MotorPlant, controller: PD, angular_frequency: Float[Array, ""]
) -> Complex[Array, ""]:
    r"""The open loop $R(j\omega) G(j\omega)$ of section 6.1.

    Args:
        plant: The drive.
        controller: The controller, its sampling disregarded.
        angular_frequency: $\omega$ [rad/s].

    Returns:
        Response [1].
    """
    derivative = continuous_derivative(angular_frequency, filter_time=controller.filter_time)
    return pd_gain(controller, derivative) * continuous_response(plant, angular_frequency)


def sampled_loop(
    plant: MotorPlant, controller: PD, angular_frequency: Float[Array, ""], *, delay: int = 1
) -> Complex[Array, ""]:
    r"""The open loop as the controller runs it, $z^{-d} R(z) G(z)$ at $z = e^{j\omega h}$.

    Args:
        plant: The drive, behind a zero-order hold.
        controller: The controller.
        angular_frequency: $\omega$ [rad/s], up to the Nyquist frequency $\pi / h$.
        delay: Samples $d$ from a measurement to its command.

    Returns:
        Response [1].
    """
    period = controller.period
    derivative = sampled_derivative(
        angular_frequency, period=period, filter_time=controller.filter_time
    )
    gain = pd_gain(controller, derivative)
    lag = sampled_delay(angular_frequency, period=period, delay=delay)
    return lag * gain * sampled_response(plant, angular_frequency, period=period)


def pd_gain(controller: PD, derivative: Complex[Array, ""]) -> Complex[Array, ""]:
    """The controller's response for that of its derivative, $K_p + K_d D$.

    Args:
        controller: The controller.
        derivative: Response $D$ of its derivative [1/s].

    Returns:
        Response [V/rad].
    """
    proportional_gain, derivative_gain = as_complex(
        controller.proportional_gain, controller.derivative_gain
    )
    return proportional_gain + derivative_gain * derivative
