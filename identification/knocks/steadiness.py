r"""Whether a ring-down's frequencies and rates stay what they are, by a test of that alone.

A carriage that gives way a little at each swing leaves less than the noise, and yet shifts the
frequency by several standard errors, as what it does goes one way all along. A test of all
residuals spreads that over hundreds of samples; this one asks for what goes one way.
"""

import dataclasses

import numpy as np
import scipy.special
from jaxtyping import Float

from identification.knocks.decay import Decay

CHANGING = 0.1
"""Significance at which frequency and damping are called changing."""


@dataclasses.dataclass(frozen=True)
class Steadiness:
    r"""What frequencies and rates that change evenly with time would explain, by the score.

    It is what $t\, \partial x / \partial \omega_i$ and $t\, \partial x / \partial \sigma_i$
    take of the residuals, beyond what the model takes: $\chi^2$ under noise.
    """

    score: float
    """Squares that they would explain, in units of the noise."""
    freedom: int
    """How many they are."""

    @property
    def likely(self) -> bool:
        """Whether noise alone explains as much."""
        return bool(scipy.special.chdtrc(self.freedom, self.score) > CHANGING)

    @property
    def weight(self) -> float:
        """Akaike's weight of the steady model against the changing one."""
        return float(scipy.special.expit(self.freedom - self.score / 2))


def steadiness(fit: Decay, time: Float[np.ndarray, " samples"]) -> Steadiness:
    """How steady the frequencies and rates of a fit are.

    Args:
        fit: A fit of a signal in units of its noise.
        time: Time of each sample [s], from 0.

    Returns:
        The steadiness.
    """
    changes = time[:, None] * fit.jacobian[:, : 2 * len(fit.rate)]
    model, _ = np.linalg.qr(fit.jacobian)
    beyond, _ = np.linalg.qr(changes - model @ (model.T @ changes))
    score = float(np.sum((beyond.T @ fit.residuals) ** 2))
    return Steadiness(score, changes.shape[1])
