r"""A co-design's unknowns as unconstrained numbers: whatever they are, the design can be run.

Gains by crossover and phase margin of a bare drive, between the bounds that the flexible
robot's margins leave. The move's time is parted between the leg and the shaper's gaps, so
that it stays what it is. The leg is a Bézier curve of seventh order from rest to rest.
"""

import itertools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.command.trajectory import QUARTIC
from scdpr_jax.robot.fields import si
from tuning.codesign.outcomes import Command, Grid
from tuning.loop.admissible import Admissible

ORDER = 7
"""Order of the leg's Bézier curve: four control points are free."""
IMPULSES = 4
"""Impulses of a design's shaper."""
_BEND = 0.2
"""Change of a control point that an unknown of one makes [1]."""


class Unknowns(eqx.Module):
    """A design as unconstrained numbers."""

    gains: Float[Array, "... 2"]
    """Logits of crossover and phase margin within what is admissible [1]."""
    parts: Float[Array, "... gaps"]
    """Logarithms of the times between the impulses over the leg's [1]."""
    amplitudes: Float[Array, "... gaps"]
    """Logarithms of the amplitudes of all impulses but the last over the last one's [1]."""
    bends: Float[Array, "... bends"]
    """Control points less those of section 6.2's curve, over a fifth of the way [1]."""

    def flat(self) -> Float[Array, " n"]:
        """All of them in one row.

        Returns:
            The row.
        """
        return jnp.concatenate([self.gains, self.parts, self.amplitudes, self.bends])

    @classmethod
    def of(cls, row: Float[Array, " n"]) -> "Unknowns":
        """The unknowns of a row.

        Args:
            row: What `flat` gave.

        Returns:
            The unknowns.
        """
        return cls(*jnp.split(row, np.cumsum([2, IMPULSES - 1, IMPULSES - 1])))


class Law(eqx.Module):
    """A design as it is run."""

    controller: PD
    """The PD controller of both drives."""
    shaper: Shaper
    """The impulses."""
    profile: Float[Array, " points"] = eqx.field(metadata=si("1"))
    """Share of the way at each of the leg's control points [1]."""
    leg_time: Float[Array, ""] = eqx.field(metadata=si("s"))
    """Time of the leg, without the shaper [s]."""


def plain_profile() -> Float[np.ndarray, " points"]:
    r"""Section 6.2's curve at `ORDER`, by raising its order.

    $$ P'_i = \frac{i}{n + 1} P_{i-1} + \left(1 - \frac{i}{n + 1}\right) P_i $$

    Returns:
        Control points [1].
    """
    points = np.asarray(QUARTIC)
    while points.size < ORDER + 1:
        share = np.arange(points.size + 1) / points.size
        points = share * np.append(0.0, points) + (1 - share) * np.append(points, 0.0)
    return points


def law(unknowns: Unknowns, move_time: Float[Array, ""], within: Admissible) -> Law:
    """The design that unknowns stand for.

    Args:
        unknowns: The unknowns.
        move_time: Time from the reference's begin to its end, the shaper included [s].
        within: Which gains are admissible.

    Returns:
        The law.
    """
    gaps = move_time * jax.nn.softmax(
        jnp.concatenate([jnp.zeros(1, unknowns.parts.dtype), unknowns.parts])
    )
    amplitudes = jax.nn.softmax(
        jnp.concatenate([unknowns.amplitudes, jnp.zeros(1, unknowns.parts.dtype)])
    )
    bends = jnp.concatenate([jnp.zeros(2), _BEND * unknowns.bends, jnp.zeros(2)])
    times = jnp.concatenate([jnp.zeros(1, gaps.dtype), jnp.cumsum(gaps[1:])])
    return Law(
        within.controller(jax.nn.sigmoid(unknowns.gains)),
        Shaper(times, amplitudes),
        plain_profile() + bends,
        gaps[0],
    )


def command(law: Law, *, on: Grid) -> Command:
    """What the drives' controllers are told, sample by sample.

    Args:
        law: The design.
        on: The samples, the last moment of the move among them.

    Returns:
        The command.
    """
    begin = -(law.leg_time + law.shaper.duration)
    elapsed = (on.time - begin)[:, None] - law.shaper.times[None]
    # At both ends the curve is flat, so that cutting it there leaves no kink.
    parameter = jnp.clip(elapsed / law.leg_time, 0.0, 1.0)
    points = [point * jnp.ones_like(parameter) for point in jnp.unstack(law.profile)]
    for _ in range(len(points) - 1):
        points = [
            (1 - parameter) * first + parameter * second
            for first, second in itertools.pairwise(points)
        ]
    controller = eqx.tree_at(
        lambda pd: pd.period, law.controller, jnp.full_like(law.controller.period, on.period)
    )
    return Command(controller, points[0] @ law.shaper.amplitudes)


def start(
    shaper: Shaper,
    *,
    move_time: float,
    gains: tuple[float, float],
) -> Unknowns:
    """The unknowns of a shaped leg of section 6.2's form.

    Args:
        shaper: A positive shaper of `IMPULSES` at the most, shorter than the move; of fewer,
            the last one is parted, its parts a little apart.
        move_time: Time of the move with the shaper [s].
        gains: Shares of what is admissible for crossover and phase margin [1].

    Returns:
        The unknowns.
    """
    more = IMPULSES - shaper.times.size
    gaps = np.append(np.diff(np.asarray(shaper.times)), np.full(more, _APART))
    last = np.full(more + 1, float(shaper.amplitudes[-1]) / (more + 1))
    amplitudes = np.append(np.asarray(shaper.amplitudes)[:-1], last)
    share = np.asarray(gains)
    return Unknowns(
        jnp.asarray(np.log(share / (1 - share))),
        jnp.asarray(np.log(gaps / (move_time - gaps.sum()))),
        jnp.asarray(np.log(amplitudes[:-1] / amplitudes[-1])),
        jnp.zeros(ORDER - 3),
    )


_APART = 5e-3
"""Time between two impulses that stand for one [s]."""
