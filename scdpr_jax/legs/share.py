"""What a command law leaves of the plain profile's vibration, over many legs."""

import numpy as np
from jaxtyping import Float

COUNTS = 0.5e-3
"""Vibration from which a leg counts, peak to peak [m]: a camera sees no less."""
_MORE = 1.05
"""Ratio to the plain profile's vibration from which a leg is worse [1]."""


def share(
    vibration: Float[np.ndarray, "*laws legs"], plain: Float[np.ndarray, "*laws legs"]
) -> Float[np.ndarray, "*laws"]:
    """Geometric mean of ratios of vibrations, over the legs that the plain profile shakes.

    Args:
        vibration: Peak to peak under a law [m].
        plain: That under Eq. (25) and the plain profile of Eq. (26) on the same legs [m].

    Returns:
        The share that is left [1]; 1 where the plain profile shakes none.
    """
    counts = plain > COUNTS
    # A micrometre is nothing, and its logarithm would be all.
    ratio = np.maximum(vibration, 1e-6) / np.where(counts, plain, 1.0)
    log = np.sum(np.where(counts, np.log(ratio), 0.0), axis=-1)
    return np.asarray(np.exp(log / np.maximum(counts.sum(axis=-1), 1)))


def worse(
    vibration: Float[np.ndarray, "*laws legs"], plain: Float[np.ndarray, "*laws legs"]
) -> Float[np.ndarray, "*laws"]:
    """Share of the legs that shake visibly and more than under the plain profile.

    Args:
        vibration: Peak to peak under a law [m].
        plain: That of the same legs under the plain profile [m].

    Returns:
        Share of the legs [1].
    """
    return np.asarray(np.mean((vibration > COUNTS) & (vibration > _MORE * plain), axis=-1))
