"""Gains and a shaper as unconstrained numbers, which a search can move anywhere."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper
from tuning.loop.admissible import Admissible

LONGEST_GAP = 0.25
"""Longest time between two impulses that is searched [s]."""
IMPULSES = 4
"""Impulses of an optimised shaper."""


class Design(eqx.Module):
    """Gains and a shaper as unconstrained numbers: whatever they are, both are sensible."""

    loop: Float[Array | np.ndarray, "... 2"]
    """Logits of crossover and phase margin within what is admissible [1]."""
    gaps: Float[Array | np.ndarray, "... gaps"]
    """Logits of the times between the impulses within `LONGEST_GAP` [1]."""
    amplitudes: Float[Array | np.ndarray, "... gaps"]
    """Logarithms of all amplitudes but the last over the last one [1]."""


@jax.jit
def controller_of(within: Admissible, design: Design) -> PD:
    """The controller of a design, at its own period.

    Args:
        within: Which gains are admissible.
        design: The design.

    Returns:
        The controller.
    """
    return within.controller(jax.nn.sigmoid(design.loop))


@jax.jit
def shaper_of(design: Design) -> Shaper:
    """The shaper of a design: all its amplitudes are positive, and their sum is 1.

    A positive shaper never asks for more speed or acceleration than the reference did.

    Args:
        design: The design.

    Returns:
        The impulses, the first at 0.
    """
    gaps = LONGEST_GAP * jax.nn.sigmoid(design.gaps)
    times = jnp.concatenate([jnp.zeros(1, gaps.dtype), jnp.cumsum(gaps)])
    logits = jnp.concatenate([design.amplitudes, jnp.zeros(1, gaps.dtype)])
    return Shaper(times, jax.nn.softmax(logits))


def middle(impulses: int) -> Design:
    """The design in the middle of what is searched.

    Args:
        impulses: Impulses of its shaper.

    Returns:
        The design.
    """
    return Design(
        loop=np.zeros(2), gaps=np.zeros(impulses - 1), amplitudes=np.zeros(impulses - 1)
    )


def spread_of(impulses: int) -> Float[np.ndarray, "n n"]:
    """Covariance of the designs that a search begins with: logits over most of their range.

    Args:
        impulses: Impulses of their shapers.

    Returns:
        The covariance of their flat numbers [1].
    """
    widths = np.concatenate(
        [np.full(2, 0.8), np.full(impulses - 1, 1.2), np.full(impulses - 1, 1.0)]
    )
    return np.diag(np.square(widths))
