"""The best shaper of impulses of 1 and -1 in turn, for a duration."""

from collections.abc import Iterable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.command.shaper import Shaper
from scdpr_jax.numerics.trust_region import TrustRegion, descend
from tuning.shapers.catalogue import UNITY_MAGNITUDE
from tuning.shapers.design.criterion import Criterion, phasors
from tuning.shapers.design.minimax import Minimax, minimise

_REGION = TrustRegion(steps=25)
"""Moves are shares of the duration [1]."""
_CLOSEST = 1e-3
"""Two impulses stay this much of the duration apart: opposite ones would vanish."""


def least_unity_residual(
    criterion: Criterion,
    *,
    duration: float,
    damping_ratio: float = 0.0,
    starts: Iterable[Shaper] = (),
) -> Shaper:
    """The unity-magnitude shaper of a duration that leaves least, seen from some starts.

    Amplitudes are given, so the instants are all there is, and the problem isn't convex: the
    gradient leads from each of the catalogue's shapers, made as long as the duration, and
    from every start to a minimum near it. The best is taken.

    Args:
        criterion: What is to be least; its modes have to include every frequency at which
            more than all may be left, see `vibration_left`.
        duration: Time from the first to the last impulse [s].
        damping_ratio: Damping ratio that the catalogue's shapers start from [1].
        starts: Other unity-magnitude shapers: what is found is never worse than one of
            them that is no longer.

    Returns:
        The shaper, of this duration or less.
    """
    catalogue = []
    for entry in UNITY_MAGNITUDE:
        unit = jax.jit(entry.design)(1.0, damping_ratio)
        catalogue.append(Shaper(unit.times * (duration / unit.duration), unit.amplitudes))
    known = [s for s in starts if float(s.duration) <= duration * (1 + 1e-12)]
    found = [_descended(criterion, shaper) for shaper in (*catalogue, *known)]
    return min([*found, *known], key=lambda shaper: float(criterion(shaper)))


def _descended(criterion: Criterion, shaper: Shaper) -> Shaper:
    def step(place: Shaper, value: float, move: float) -> tuple[Shaper, float]:
        sizes, end = place.amplitudes, shaper.duration
        moved = Shaper(_moved(criterion, place.times, sizes, end, jnp.asarray(move)), sizes)
        return moved, float(criterion(moved))

    return descend(step, shaper, float(criterion(shaper)), region=_REGION)[0]


@jax.jit
def _moved(
    criterion: Criterion,
    times: Float[Array, " impulses"],
    amplitudes: Float[Array, " impulses"],
    end: Float[Array, ""],
    move: Float[Array, ""],
) -> Float[Array, " impulses"]:
    """Instants after a step within a trust region; the first and the last one stay."""

    def parts(inner: Float[Array, " inner"]) -> Float[Array, "2 modes"]:
        places = jnp.concatenate([jnp.zeros(1), inner, jnp.ones(1)])
        return phasors(criterion, end * places, end=end) @ amplitudes

    places = times / end
    inner = places[1:-1]
    # Half of the gap to a neighbour at most: the order stays.
    gaps = jnp.diff(places)
    room = jnp.maximum((gaps - _CLOSEST) / 2, 1e-9)
    problem = Minimax(
        offset=parts(inner),
        slope=jax.jacfwd(parts)(inner),
        tolerated=criterion.tolerated,
        weights=criterion.weights,
        lower=-jnp.minimum(move, room[:-1]),
        upper=jnp.minimum(move, room[1:]),
        balance=jnp.zeros_like(inner),
    )
    found = minimise(problem, jnp.zeros_like(inner), jnp.asarray(1e-9)).x
    return end * jnp.concatenate([jnp.zeros(1), inner + found, jnp.ones(1)])
