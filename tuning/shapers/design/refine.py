"""A shaper made better by moving its impulses, never worse."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.command.shaper import Shaper
from scdpr_jax.numerics.trust_region import TrustRegion, descend
from tuning.shapers.design.criterion import Criterion, phasors
from tuning.shapers.design.minimax import Minimax, minimise

IMPULSES = 8
"""Impulses that a refinement has room for: more than a spread needs."""
_REGION = TrustRegion(steps=14, worthwhile=1e-6)
"""Moves are shares of the duration [1]."""
_LEAST_GAP = 1e-9
_RELATIVE_GAP = 1e-4
_NOTHING = 1e-7

_Impulses = tuple[Float[Array, " impulses"], Float[Array, " impulses"]]
"""Instants [s] and amplitudes [1]."""


def refined(criterion: Criterion, shaper: Shaper) -> Shaper:
    """A shaper of the same duration that leaves no more, by sequential convex programs.

    The phasors are linear in the amplitudes and, over small moves, in the instants. Each
    step is the convex minimum over amplitudes and over moves within a trust region, which
    widens where the linear model held and narrows where it didn't. Ends with a kink as
    easily as without: a minimax has its minimum at one.

    Args:
        criterion: What is to be less.
        shaper: Positive impulses, the first at 0; at most `IMPULSES`.

    Returns:
        The shaper; impulses that have vanished or met are gone.
    """
    if shaper.times.size > IMPULSES:
        return shaper

    def step(place: _Impulses, value: float, move: float) -> tuple[_Impulses, float]:
        gap = jnp.asarray(max(_LEAST_GAP, _RELATIVE_GAP * value))
        moved = _step(criterion, *place, shaper.duration, jnp.asarray(move), gap)
        return moved[:2], float(moved[2])

    value = float(criterion(shaper))
    place, _ = descend(step, _padded(shaper), value, region=_REGION)
    better = _cleaned(*place)
    return better if float(criterion(better)) < value else shaper


def _padded(shaper: Shaper) -> _Impulses:
    """Room for all impulses, so that one compilation serves; idle ones stand at the start."""
    idle = jnp.zeros(IMPULSES - shaper.times.size, shaper.times.dtype)
    return (
        jnp.concatenate([idle, shaper.times]),
        jnp.concatenate([idle, shaper.amplitudes]),
    )


@jax.jit
def _step(
    criterion: Criterion,
    times: Float[Array, " impulses"],
    amplitudes: Float[Array, " impulses"],
    end: Float[Array, ""],
    move: Float[Array, ""],
    gap: Float[Array, ""],
) -> tuple[Float[Array, " impulses"], Float[Array, " impulses"], Float[Array, ""]]:
    """Instants and amplitudes after a step, and what they leave."""
    count = times.size

    def parts(
        places: Float[Array, " impulses"], sizes: Float[Array, " impulses"]
    ) -> Float[Array, "2 modes"]:
        return phasors(criterion, end * places, end=end) @ sizes

    places = times / end
    basis = phasors(criterion, times, end=end)
    along = jax.jacfwd(parts)(places, amplitudes)
    # The ends stay, so that the duration does; an idle impulse may neither move nor count.
    idle = amplitudes == 0
    fixed = idle | (places <= 0) | (places >= 1)
    slack = jnp.asarray(1e-9, end.dtype)
    reach = jnp.where(fixed, slack, move)
    problem = Minimax(
        offset=basis @ amplitudes,
        slope=jnp.concatenate([along, basis], axis=2),
        tolerated=criterion.tolerated,
        weights=criterion.weights,
        lower=jnp.concatenate([-reach, jnp.where(idle, -slack, -amplitudes - slack)]),
        upper=jnp.concatenate([reach, jnp.where(idle, slack, 1.0)]),
        balance=jnp.concatenate([jnp.zeros(count, end.dtype), jnp.ones(count, end.dtype)]),
    )
    found = minimise(problem, jnp.zeros(2 * count, end.dtype), gap).x
    moved = jnp.where(fixed, places, jnp.clip(places + found[:count], 0, 1))
    grown = jnp.where(idle, 0.0, jnp.maximum(amplitudes + found[count:], 0))
    grown = grown / jnp.sum(grown)
    size = jnp.sqrt(jnp.sum(jnp.square(parts(moved, grown)), axis=0))
    left = jnp.max(criterion.weights @ jnp.maximum(size - criterion.tolerated, 0))
    return end * moved, grown, left


def _cleaned(times: Float[Array, " impulses"], amplitudes: Float[Array, " impulses"]) -> Shaper:
    """In order of time, without impulses of nothing."""
    used = amplitudes > _NOTHING
    order = jnp.argsort(times[used])
    kept, sizes = times[used][order], amplitudes[used][order]
    return Shaper(kept - kept[0], sizes / jnp.sum(sizes))
