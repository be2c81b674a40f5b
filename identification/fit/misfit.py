r"""How much a channel's residuals count: as noise, and as the model's own error.

A channel is one encoder of a run, or one coordinate of its camera. With $\chi^2$ the mean
squared residual in units of the sensor's noise and $n$ measurements, its misfit is

$$ n \chi^2 \;\text{ up to } \chi^2 = c, \qquad
   n \Big( c + \frac{1}{L} \ln(1 + L (\chi^2 - c)) \Big) \;\text{ beyond.} $$

Up to $c$ that is least squares. Beyond, the model errs: by an amount that isn't known, and
for as long as the error stands, so that the $L$ measurements within `ERROR_TIME` are worth
one. A thousand samples a second of a diverging encoder then count no more than thirty
camera frames. The Gauss-Newton model is that of least squares with the misfit's slope as
weight.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

NOISE = 1.5
"""Mean squared residual $c$ up to which a channel counts as noise [1]."""

ERROR_TIME = 0.1
"""How long an error of the model stands [s]: half a period of the slowest vibration."""


class Misfit(NamedTuple):
    """Misfit of the channels of one stream."""

    cost: Float[Array, " channels"]
    """The misfit."""
    weight: Float[Array, " channels"]
    """Its slope over that of least squares, 1 for noise."""


def channel_misfit(
    residual: Float[Array, "samples channels"],
    count: Float[Array, " channels"] | Int[Array, " channels"],
    duration: Float[Array, ""],
) -> Misfit:
    """Misfit of the channels of one stream of a run.

    Args:
        residual: Residuals over the noise; zero where nothing was measured [1].
        count: Measurements of each channel [1].
        duration: Length of the run [s].

    Returns:
        Misfit and weight of each channel.
    """
    count = count.astype(residual.dtype)
    measured = jnp.maximum(count, 1.0)
    chi_square = jnp.sum(jnp.square(residual), axis=0) / measured
    together = jnp.maximum(measured * (ERROR_TIME / duration), 1.0)
    excess = jnp.maximum(chi_square - NOISE, 0.0)
    grown = jnp.log1p(together * excess) / together
    return Misfit(
        cost=count * (jnp.minimum(chi_square, NOISE) + grown),
        weight=1 / (1 + together * excess),
    )
