"""What a shaper is judged by: convex functions of the vibration that it leaves in modes."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.command.shaper import Shaper, impulse_phasors
from scdpr_jax.robot.fields import real, si


class Criterion(eqx.Module):
    r"""The largest of some weighted sums of residual vibrations.

    $$ \max_g \sum_k W_{gk} \max(V_k - \tau_k, 0) $$

    with $V_k$ the residual vibration in mode k. The worst case over a spread and the
    vibration left of a spectrum are both of this form. It is convex in the amplitudes of
    impulses at given times, since each $V_k$ is.
    """

    frequency: Float[Array, " modes"] = eqx.field(converter=real, metadata=si("Hz", "f"))
    """Undamped natural frequencies [Hz]."""
    damping_ratio: Float[Array, " modes"] = eqx.field(
        converter=real, metadata=si("1", r"\zeta")
    )
    """Damping ratios [1]."""
    tolerated: Float[Array, " modes"] = eqx.field(converter=real, metadata=si("1", r"\tau"))
    """Residual vibrations that cost nothing [1]."""
    weights: Float[Array, "groups modes"] = eqx.field(converter=real, metadata=si("1", "W"))
    """Weights of the modes in each of the sums [1]."""

    def __call__(self, shaper: Shaper) -> Float[Array, ""]:
        """What a shaper leaves by this criterion [1]."""
        return _left(self, shaper.times, shaper.amplitudes)


@jax.jit
def _left(
    criterion: Criterion,
    times: Float[Array, " impulses"],
    amplitudes: Float[Array, " impulses"],
) -> Float[Array, ""]:
    parts = phasors(criterion, times, end=times[-1]) @ amplitudes
    size = jnp.sqrt(jnp.sum(jnp.square(parts), axis=0))
    return jnp.max(criterion.weights @ jnp.maximum(size - criterion.tolerated, 0))


def phasors(
    criterion: Criterion, times: Float[Array, " impulses"], *, end: Float[Array, ""]
) -> Float[Array, "2 modes impulses"]:
    """What each of some unit impulses leaves in each mode, see `impulse_phasors`.

    Args:
        criterion: The modes.
        times: Instants of the impulses [s].
        end: Instant at which the vibration is measured [s].

    Returns:
        Cosine and sine parts [1].
    """
    of_mode = jax.vmap(
        lambda f, ratio: impulse_phasors(times, end=end, frequency=f, damping_ratio=ratio)
    )
    return jnp.swapaxes(of_mode(criterion.frequency, criterion.damping_ratio), 0, 1)


def worst_residual(frequency: Any, damping_ratio: Any, *, limits: Any = None) -> Criterion:
    """The largest residual vibration over a spread of modes.

    Args:
        frequency: Undamped natural frequencies: of a map, of a posterior's samples [Hz].
        damping_ratio: Their damping ratios [1].
        limits: What each mode may be left with [1]; residuals are then counted over their
            limits, and 1 is what keeps all of them. Default: residuals as they are.

    Returns:
        The criterion.
    """
    frequency = real(frequency)
    weights = jnp.ones_like(frequency) if limits is None else 1 / real(limits)
    return Criterion(frequency, damping_ratio, jnp.zeros_like(frequency), jnp.diag(weights))
