"""A measured vibration spectrum, and what of it a shaper leaves."""

import dataclasses

import numpy as np
from jaxtyping import Float

from scdpr_jax.robot.fields import si
from tuning.shapers.design.criterion import Criterion

DAMPING_RATIOS = (0.075, 0.1, 0.15)
"""Damping ratios that a shaper for a measured spectrum is judged at [1]."""
THRESHOLD = 0.05
"""Share of the highest peak below which vibration doesn't count [1]."""
_ROOM = 64
"""Modes of a criterion come in such numbers, so that spectra share compiled code."""


@dataclasses.dataclass(frozen=True, eq=False)
class Spectrum:
    """How strongly a machine vibrates at each frequency when it is shaken alike."""

    frequency: Float[np.ndarray, " bins"] = dataclasses.field(metadata=si("Hz", "f"))
    """Frequencies [Hz], positive and increasing."""
    power: Float[np.ndarray, " bins"] = dataclasses.field(metadata=si("1", "P"))
    """Power spectral density over the frequency, relative to its highest value [1]."""

    @property
    def peak(self) -> float:
        """Frequency of the highest value [Hz]."""
        return float(self.frequency[np.argmax(self.power)])


def vibration_left(
    spectrum: Spectrum,
    *,
    damping_ratios: tuple[float, ...] = DAMPING_RATIOS,
    highest_residual: float = 1.0,
) -> Criterion:
    r"""The share of a spectrum's vibration that a shaper leaves, at the worst damping ratio.

    $$ \max_\zeta \frac{\sum_k \max(V(f_k, \zeta) P_k - P_{max} / 20,\, 0)}
                       {\sum_k \max(P_k - P_{max} / 20,\, 0)} $$

    Args:
        spectrum: The spectrum.
        damping_ratios: Damping ratios to be ready for [1].
        highest_residual: Highest residual vibration V that a shaper of this kind can leave
            [1]: 1 for positive impulses, their number for impulses of 1 and -1. Bins that
            can't count even then are left out.

    Returns:
        The criterion, one sum for each damping ratio.
    """
    excess = np.maximum(spectrum.power - THRESHOLD, 0)
    counts = spectrum.power * highest_residual > THRESHOLD
    frequency, power = spectrum.frequency[counts], spectrum.power[counts]
    share = power / excess.sum()
    bins, ratios = frequency.size, len(damping_ratios)
    idle = -bins * ratios % _ROOM
    weights = np.kron(np.eye(ratios), share)
    # What tolerates all that can be left never counts; a weight keeps its slack bounded.
    idle_weights = np.full((ratios, idle), share.mean())
    return Criterion(
        frequency=np.append(np.tile(frequency, ratios), np.full(idle, spectrum.peak)),
        damping_ratio=np.append(np.repeat(damping_ratios, bins), np.full(idle, 0.1)),
        tolerated=np.append(
            np.tile(THRESHOLD / power, ratios), np.full(idle, highest_residual)
        ),
        weights=np.append(weights, idle_weights, axis=1),
    )
