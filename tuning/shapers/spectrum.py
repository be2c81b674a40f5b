"""A measured vibration spectrum, and what of it a shaper leaves."""

import dataclasses
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import block_diag

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
    power: Float[np.ndarray, "*sensors bins"] = dataclasses.field(metadata=si("1", "P"))
    """Power spectral density over the frequency, relative to its highest value [1]; a row for
    each sensor where there are several."""

    @property
    def by_sensor(self) -> Float[np.ndarray, "sensors bins"]:
        """The power, a row for each sensor [1]."""
        return np.atleast_2d(self.power)

    @property
    def peaks(self) -> tuple[float, ...]:
        """Frequency of each sensor's highest value [Hz]."""
        return tuple(float(f) for f in self.frequency[np.argmax(self.by_sensor, axis=1)])

    @property
    def peak(self) -> float:
        """Frequency of the highest value [Hz], the lowest of several sensors'."""
        return min(self.peaks)


def vibration_left(
    spectrum: Spectrum,
    *,
    damping_ratios: tuple[float, ...] = DAMPING_RATIOS,
    highest_residual: float = 1.0,
) -> Criterion:
    r"""The share of a spectrum's vibration that a shaper leaves, at the worst damping ratio.

    $$ \max_\zeta \frac{\sum_k \max(V(f_k, \zeta) P_k - P_{max} / 20,\, 0)}
                       {\sum_k \max(P_k - P_{max} / 20,\, 0)} $$

    Of several sensors the worst counts: a shaper for one of them is blind to what another
    shows, and the sum of both hides the one that shakes less.

    Args:
        spectrum: The spectrum.
        damping_ratios: Damping ratios to be ready for [1].
        highest_residual: Highest residual vibration V that a shaper of this kind can leave
            [1]: 1 for positive impulses, their number for impulses of 1 and -1. Bins that
            can't count even then are left out.

    Returns:
        The criterion, one sum for each damping ratio and sensor.
    """
    sums = [
        _Sum(*counted, ratio)
        for counted in _counted(spectrum, highest_residual)
        for ratio in damping_ratios
    ]
    frequency, ratio, tolerated = (
        np.concatenate(column)
        for column in zip(
            *((s.frequency, np.full(s.share.size, s.ratio), s.tolerated) for s in sums),
            strict=True,
        )
    )
    idle = -frequency.size % _ROOM
    weights = block_diag(*(s.share for s in sums))
    # What tolerates all that can be left never counts; a weight keeps its slack bounded.
    idle_weights = np.full((len(sums), idle), np.mean([s.share.mean() for s in sums]))
    return Criterion(
        frequency=np.append(frequency, np.full(idle, spectrum.peak)),
        damping_ratio=np.append(ratio, np.full(idle, 0.1)),
        tolerated=np.append(tolerated, np.full(idle, highest_residual)),
        weights=np.append(weights, idle_weights, axis=1),
    )


class _Sum(NamedTuple):
    """What one sensor shows, judged at one damping ratio."""

    frequency: Float[np.ndarray, " bins"]
    share: Float[np.ndarray, " bins"]
    tolerated: Float[np.ndarray, " bins"]
    ratio: float


def _counted(
    spectrum: Spectrum, highest_residual: float
) -> Iterator[tuple[Float[np.ndarray, " bins"], ...]]:
    """Frequencies [Hz], shares and tolerated residuals [1] of each sensor's bins that count."""
    for power in spectrum.by_sensor:
        excess = np.maximum(power - THRESHOLD, 0)
        counts = power * highest_residual > THRESHOLD
        share = power[counts] / excess.sum()
        yield spectrum.frequency[counts], share, THRESHOLD / power[counts]
