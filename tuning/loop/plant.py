r"""The drive as a controller's plant: voltage to pulley angle, Eq. (24)."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Complex, Float

from scdpr_jax.robot.fields import real, si


class MotorPlant(eqx.Module):
    r"""A drive with its pulley, $G(s) = g / (s (s + p))$, Eq. (24)."""

    gain: Float[Array, "..."] = eqx.field(converter=real, metadata=si("rad/s^2/V", "g"))
    """Angular acceleration per volt $g = k_v / J$ [rad/s²/V]."""
    pole: Float[Array, "..."] = eqx.field(converter=real, metadata=si("1/s", "p"))
    """Viscous pole $p = b / J$ [1/s]."""


def published_plant() -> MotorPlant:
    """The plant of Eq. (24), $2169 / (s (s + 16.68))$, whose angle is in degrees.

    Returns:
        The plant in radians: 37.86 rad/s²/V and 16.68 1/s.
    """
    return MotorPlant(gain=2169.0 * jnp.pi / 180, pole=16.68)


def continuous_response(
    plant: MotorPlant, angular_frequency: Float[Array, ""]
) -> Complex[Array, ""]:
    r"""Frequency response $G(j\omega)$ of the plant.

    Args:
        plant: The plant.
        angular_frequency: $\omega$ [rad/s].

    Returns:
        Response [rad/V].
    """
    s = imaginary(angular_frequency)
    gain, pole = as_complex(plant.gain, plant.pole)
    return gain / (s * (s + pole))


def sampled_response(
    plant: MotorPlant, angular_frequency: Float[Array, ""], *, period: Float[Array, ""]
) -> Complex[Array, ""]:
    r"""Frequency response of the plant behind a zero-order hold, exactly, $z = e^{j\omega h}$.

    $$ G(z) = g h^2 \frac{\varphi_2 z + \varphi_1 - \varphi_2}{(z - 1)(z - e^{-x})}, \qquad
       x = p h, \quad \varphi_1 = \frac{1 - e^{-x}}{x}, \quad
       \varphi_2 = \frac{e^{-x} - 1 + x}{x^2} $$

    Args:
        plant: The plant.
        angular_frequency: $\omega$ [rad/s], up to $\pi / h$.
        period: Sample period $h$ [s].

    Returns:
        Response [rad/V].
    """
    x = plant.pole * period
    second = _second_phi(x)
    first = 1 - x * second
    # z - 1 from the half angle, and z - e^{-x} from it, keep their digits at low frequency.
    step = shift_minus_one(angular_frequency * period)
    gain, first, second, root = as_complex(
        plant.gain * jnp.square(period), first, second, jnp.expm1(-x)
    )
    return gain * (second * step + first) / (step * (step - root))


def shift_minus_one(angle: Float[Array, ""]) -> Complex[Array, ""]:
    r"""$e^{j\theta} - 1$ without cancellation, $2j \sin(\theta/2)\, e^{j\theta/2}$.

    Args:
        angle: $\theta$ [rad].

    Returns:
        The difference [1].
    """
    half = angle / 2
    return imaginary(2 * jnp.sin(half)) * jnp.exp(imaginary(half))


def imaginary(number: Float[Array, ""]) -> Complex[Array, ""]:
    r"""$j x$, explicitly: strict promotion mixes no real with complex arrays.

    Args:
        number: A real number.

    Returns:
        It times the imaginary unit, in the complex type of its precision.
    """
    return jax.lax.complex(jnp.zeros_like(number), number)


def as_complex(*numbers: Float[Array, "..."]) -> tuple[Complex[Array, "..."], ...]:
    """Real numbers in the complex type of their precision.

    Args:
        *numbers: Real numbers, or arrays of them.

    Returns:
        The same numbers.
    """
    return tuple(jax.lax.complex(number, jnp.zeros_like(number)) for number in numbers)


def _second_phi(x: Float[Array, ""]) -> Float[Array, ""]:
    r"""$(e^{-x} - 1 + x) / x^2$, also at small x, where its numerator cancels."""
    small = jnp.abs(x) < 0.1
    # Eight terms: the ninth is below 0.1^8 / 10! = 3e-15 of the first.
    series = jnp.zeros_like(x)
    for order in range(9, 1, -1):
        series = (1 - x * series) / order
    safe = jnp.where(small, jnp.ones_like(x), x)
    return jnp.where(small, series, (jnp.expm1(-safe) + safe) / jnp.square(safe))
