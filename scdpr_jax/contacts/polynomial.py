r"""Polynomials in a step's time, which runs from 0 to 1: their zeros and their moments.

What contacts ask of a step is asked of polynomials of second degree: when a speed or a reserve
of friction falls through zero, and what a difference of friction does until the end. A cubic
would be nearer to the motion, but its zeros have no closed form that could be differentiated
through a double zero. So a zero is that of the quadratic, and `Cubic` moves it by one step of
Newton's: the error is of the order of the correction's square, for one division. Iterating to
the cubic's zero would be a loop in each of some ten thousand steps, for digits that the rest
of the step doesn't have.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float


class Quadratic(NamedTuple):
    """A polynomial of second degree in the step's time."""

    constant: Float[Array, ""]
    linear: Float[Array, ""]
    quadratic: Float[Array, ""]

    def __call__(self, time: Float[Array, ""] | float) -> Float[Array, ""]:
        """Value at a time of the step."""
        return self.constant + time * (self.linear + time * self.quadratic)

    def later(self, time: Float[Array, ""]) -> "Quadratic":
        """The same in the time since an instant."""
        slope = self.linear + 2 * time * self.quadratic
        return Quadratic(self(time), slope, self.quadratic)


class Cubic(NamedTuple):
    r"""A quadratic $p$ bent at its end, $p(\theta) + b\,\theta^2 (\theta - 1)$."""

    quadratic: Quadratic
    bend: Float[Array, ""]
    """What the bend $b$ adds to the slope at the end."""

    def __call__(self, time: Float[Array, ""]) -> Float[Array, ""]:
        """Value at a time of the step."""
        return self.quadratic(time) + self.bend * (jnp.square(time) * (time - 1))


def cubic_between(
    start: Float[Array, ""],
    end: Float[Array, ""],
    *,
    slope: Float[Array, ""],
    end_slope: Float[Array, ""],
) -> Cubic:
    """The cubic with these values and slopes at both ends of the step.

    Args:
        start: Value at the beginning.
        end: Value at the end.
        slope: Slope at the beginning, per step.
        end_slope: Slope at the end, per step.

    Returns:
        The cubic.
    """
    quadratic = end - start - slope
    return Cubic(Quadratic(start, slope, quadratic), end_slope - slope - 2 * quadratic)


def combination(*terms: tuple[Float[Array, ""] | int, Quadratic]) -> Quadratic:
    """A sum of polynomials with their weights.

    Args:
        terms: Weights and polynomials; a plain 0 leaves its polynomial out.

    Returns:
        The sum.
    """
    weighted = [term for term in terms if not isinstance(term[0], int) or term[0]]
    return Quadratic(
        *(sum(weight * polynomial[n] for weight, polynomial in weighted) for n in range(3))
    )


def falling_zero(polynomial: Quadratic) -> tuple[Float[Array, ""], Bool[Array, ""]]:
    r"""The zero at which a quadratic falls, and whether there is one.

    Of the two forms $(-p_1 \mp \sqrt{D}) / 2p_2$ and $2p_0 / (-p_1 \pm \sqrt{D})$ the one in
    which nothing cancels: the first where it rises at the beginning, the second elsewhere. So
    a straight line needs no case of its own, and one from zero has its other zero.

    Args:
        polynomial: The quadratic.

    Returns:
        The zero, of either sign and 0 without one, and whether it exists.
    """
    constant, linear, quadratic = polynomial
    discriminant = jnp.square(linear) - 4 * quadratic * constant
    real = discriminant > 0
    root = jnp.sqrt(jnp.where(real, discriminant, 1.0))
    rises = linear > 0
    above = jnp.where(rises, -linear - root, 2 * constant)
    below = jnp.where(rises, 2 * quadratic, root - linear)
    exists = real & (~rises | (quadratic < 0)) & (below != 0)
    return jnp.where(exists, above / jnp.where(exists, below, 1.0), 0.0), exists


def fall(
    reserve: Cubic, *, left: Float[Array, ""] | float, set_going: Bool[Array, ""]
) -> tuple[Float[Array, ""], Bool[Array, ""]]:
    """When a reserve falls below zero first, and whether it does.

    What rises from zero turns back at its other zero. Of a contact that has just been set
    going only roundings could say that it stops at once; of another one that stands as it
    falls, because several stop together, it is so.

    Args:
        reserve: The reserve.
        left: Time left in the step.
        set_going: Whether its contact has just been set going.

    Returns:
        The time, all that is left if it doesn't fall.
    """
    time, exists = falling_zero(reserve.quadratic)
    exists = exists & ((reserve.quadratic.linear > 0) | ~set_going)
    time = jnp.maximum(time, 0.0)
    falls = exists & (time < left)
    time = jnp.where(falls, time, left)
    return jnp.where(falls, nearer(reserve, time), time), falls


def nearer(reserve: Cubic, time: Float[Array, ""]) -> Float[Array, ""]:
    """A zero of a cubic's quadratic that falls there, moved towards the cubic's own.

    Args:
        reserve: The cubic.
        time: The quadratic's zero.

    Returns:
        One step of Newton's from it, within the step.
    """
    (_, linear, quadratic), bend = reserve
    excess = bend * jnp.square(time) * (time - 1)
    slope = linear + time * (2 * quadratic + bend * (3 * time - 2))
    falls = slope < 0
    correction = jnp.where(falls, excess / jnp.where(falls, slope, 1.0), 0.0)
    return jnp.clip(time - correction, 0.0, 1.0)


def moment(order: int, left: Float[Array, ""], change: Quadratic) -> Float[Array, ""]:
    r"""$\int (1-\theta)^k p(\theta)\,d\theta$ over the time left, k the order.

    With p in the time since the instant, $\int_0^u (u-\tau)^k \tau^n d\tau
    = u^{k+n+1} k!\,n!/(k+n+1)!$.

    Args:
        order: The order k.
        left: Time left in the step, u.
        change: The polynomial p.

    Returns:
        The moment [in the polynomial's unit].
    """
    constant, linear, quadratic = change
    k = order + 1
    return left**k * (
        constant / k
        + left * linear / (k * (k + 1))
        + jnp.square(left) * 2 * quadratic / (k * (k + 1) * (k + 2))
    )
