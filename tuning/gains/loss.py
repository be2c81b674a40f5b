"""How far a leg is from what is wanted of it, as one number to search by.

Vibration alone would be bought with tracking: soft gains shake little and follow badly. So the
errors are held where the plain PD has them by terms that are zero below and steep above, and
only the vibration is asked to fall.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.legs.measures import LegMeasures


def loss(
    measures: LegMeasures, baseline: LegMeasures, *, target: float = 0.35
) -> Float[Array, ""]:
    r"""How far a run is from what is wanted of it, each metric over its baseline's.

    The vibration counts throughout, and four times above the target share; the resting error
    and that of Eq. (26) count where they come near the baseline's or exceed it, a millimetre
    further from the target as much as one and a half of vibration.

    Args:
        measures: Measures of the run.
        baseline: Those of the same manoeuvre with the PD of Eq. (25) alone.
        target: Share of the baseline's vibration that is to be left at most [1].

    Returns:
        Loss [1].
    """
    # A capped share keeps one bad leg from hiding what another does.
    capped = 3 * jnp.tanh(measures.smooth_vibration / baseline.smooth_vibration / 3)
    # Where friction leaves the robot is a matter of luck, and the baseline may have had it: its
    # resting error is no measure of its own growth.
    size = jnp.maximum(baseline.smooth_vibration, 1e-3)
    further = (measures.resting_error - 0.93 * baseline.resting_error) / size
    tracking = measures.largest_error / baseline.largest_error
    return (
        capped
        + 3 * _above(capped, target)
        + 6 * _above(further, 0.0)
        + 8 * _above(tracking, 0.97)
    )


def _above(share: Float[Array, ""], limit: float) -> Float[Array, ""]:
    return jnp.maximum(share - limit, 0.0)
