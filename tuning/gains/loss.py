r"""What is left of the plain profile's vibration, over many legs, as one number to search by.

A leg counts by the ratio of its vibration to that of the same robot's under Eq. (25) without a
shaper, and legs count alike, so that it is their geometric mean that falls. Vibration alone
would be bought with the place where the robot rests: soft gains and a slow end leave the upper
carriage further behind. So the resting error is held where the plain profile has it, by a term
that is zero below and steep above, and so is each leg's vibration. Errors on the way aren't:
legs that are to be still at their end may follow later.
"""

import numpy as np
from jaxtyping import Float

from scdpr_jax.legs.share import COUNTS
from tuning.result.prediction import LegsOutcome

_UNSEEN = 0.3e-3
"""Vibration below which less is no better [m]."""
_LEAST = 0.05
"""Least ratio that counts [1]: one perfect leg doesn't make up for a bad one."""
_WORSE = 5.0
"""Weight of what is above the plain profile's vibration [1]."""
_RESTING = 3.0
"""Weight of resting further from the target [1]."""


def loss(after: LegsOutcome, before: LegsOutcome) -> Float[np.ndarray, "..."]:
    r"""How far laws are from what is wanted of them.

    $$ \overline{\log r} + 5\,\overline{\max(r - 1, 0)} + 3 \max(R - 1, 0) $$

    with $r$ the ratios of vibrations and $R$ that of the mean resting errors.

    Args:
        after: What they come to under the laws, the legs along the last axis.
        before: Those of the same legs under Eq. (25) alone.

    Returns:
        Loss of each law [1]; 0 for the plain profile on legs that shake, negative for less
        vibration.
    """
    ratio = ratios(after, before)
    resting = after.resting_error.mean(axis=-1) / before.resting_error.mean(axis=-1)
    return np.asarray(
        np.log(ratio).mean(axis=-1)
        + _WORSE * np.maximum(ratio - 1, 0).mean(axis=-1)
        + _RESTING * np.maximum(resting - 1, 0)
    )


def ratios(after: LegsOutcome, before: LegsOutcome) -> Float[np.ndarray, "..."]:
    """Vibrations over the plain profile's, leg by leg.

    Args:
        after: What they come to under the laws.
        before: Those of the same legs under Eq. (25) alone.

    Returns:
        Ratios [1]; where both are too small to be seen there is little to tell.
    """
    vibration = np.maximum(after.vibration, _UNSEEN)
    return np.maximum(vibration / np.maximum(before.vibration, COUNTS), _LEAST)
