r"""Gains and a shaper as unconstrained numbers, which a search can move anywhere.

The shaper has three impulses: two that share the way, and a small last one of either sign. What
excites a vibration here is the upper carriage that breaks away at speed, and that linear theory
doesn't know: while both carriages slide the mode is slower than the held one, so the two
impulses stand further apart than ZV's. The last one works through friction. As a slow tail it
keeps the upper carriage creeping, and dry friction then takes the vibration's energy. As a
return, the leg goes a little too far and comes back: the upper carriage sticks on the turn, and
the way back takes away the slope that it was left with, so that the robot rests nearer.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper
from tuning.loop.admissible import Admissible

LONGEST_GAPS = (0.6, 1.2)
"""Longest times between the impulses that are searched [s]."""
LONGEST = sum(LONGEST_GAPS)
"""Longest shaper [s]."""
LARGEST_TAIL = 0.2
"""Largest share of the way of the last impulse, of either sign [1]."""


class Design(eqx.Module):
    """Gains and a shaper as unconstrained numbers: whatever they are, both are sensible."""

    loop: Float[Array | np.ndarray, "... 2"]
    """Logits of crossover and phase margin within what is admissible [1]."""
    gaps: Float[Array | np.ndarray, "... 2"]
    """Logits of the times between the impulses within `LONGEST_GAPS` [1]."""
    first: Float[Array | np.ndarray, "..."]
    """Logit of the first impulse's share of both [1]."""
    tail: Float[Array | np.ndarray, "..."]
    """Hyperbolic area tangent of the last impulse over `LARGEST_TAIL` [1]."""


SPREAD = Design(
    loop=np.array([0.5, 0.5]),
    gaps=np.array([0.25, 0.4]),
    first=np.asarray(0.2),
    tail=np.asarray(0.12),
)
"""Standard deviations of the designs that a search begins with."""


def searched_from(frequency: float) -> Design:
    """Where a search begins: about where those on rigs of all kinds ended.

    Args:
        frequency: Natural frequency with both carriages held [Hz].

    Returns:
        Soft gains, impulses a period of the held mode apart, and a return of 4 %.
    """
    apart = np.clip(_APART / frequency / LONGEST_GAPS[0], 0.1, 0.9)
    return Design(
        loop=np.array([-2.3, -0.7]),
        gaps=np.array([np.log(apart / (1 - apart)), 1.3]),
        first=np.asarray(0.1),
        tail=np.asarray(-0.22),
    )


def flat(design: Design) -> Float[np.ndarray, " n"]:
    """A design as a row of numbers.

    Args:
        design: The design.

    Returns:
        Its numbers.
    """
    return np.concatenate([np.ravel(leaf) for leaf in jax.tree.leaves(design)])


def design_of(numbers: Float[Array | np.ndarray, "... n"]) -> Design:
    """The design that a row of numbers is.

    Args:
        numbers: The row, or several.

    Returns:
        The design.
    """
    return Design(numbers[..., :2], numbers[..., 2:4], numbers[..., 4], numbers[..., 5])


_APART = 1.1
"""Time between the first two impulses over the held mode's period [1]."""


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
    r"""The shaper of a design.

    $$ A = [s (1 - e),\; (1 - s)(1 - e),\; e] $$

    with $s$ the first impulse's share of both and $e$ the last impulse.

    Args:
        design: The design.

    Returns:
        The impulses, the first at 0.
    """
    gaps = jnp.asarray(LONGEST_GAPS, design.gaps.dtype) * jax.nn.sigmoid(design.gaps)
    share, tail = jax.nn.sigmoid(design.first), LARGEST_TAIL * jnp.tanh(design.tail)
    both = (1 - tail) * jnp.stack([share, 1 - share])
    return Shaper(
        jnp.concatenate([jnp.zeros(1, gaps.dtype), jnp.cumsum(gaps)]),
        jnp.concatenate([both, tail[None]]),
    )
