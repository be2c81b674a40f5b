r"""A manoeuvre in space, its lag taken off.

A shaper delays the motion: against its reference a shaped run is off by the way of the delay,
though it may pass through the same places. So each run is moved by the lag that brings it
nearest to the reference, and what is left is how far it is off in space.
"""

import dataclasses

import numpy as np
from jaxtyping import Float

from scdpr_jax.legs.leg import Leg

LONGEST = 3.0
"""Lag that is looked for at most [s]: no shaper of the catalogue is longer."""
_COARSE = 20
"""Samples between the lags that are tried first."""


@dataclasses.dataclass(frozen=True, eq=False)
class InSpace:
    """A run beside its reference at the same place of the way."""

    lag: float
    """By how much the run is behind the reference [s]."""
    time: Float[np.ndarray, " samples"]
    """Time of the reference [s]."""
    reference: Float[np.ndarray, "samples 2"]
    """Where the end-effector was to be [m]."""
    pose: Float[np.ndarray, "samples 2"]
    """Where it was by the lag later [m]."""
    arrival: float
    """When the reference comes to rest, on its own clock [s]."""

    @property
    def off(self) -> Float[np.ndarray, "samples 2"]:
        """Where it was from where it was to be [m]."""
        return self.pose - self.reference

    @property
    def distance(self) -> Float[np.ndarray, " samples"]:
        """How far that is [m]."""
        return np.linalg.norm(self.off, axis=1)


def in_space(run: Leg) -> InSpace:
    """A run with its lag taken off.

    Args:
        run: The run; it goes on for some time after its reference has come to rest.

    Returns:
        Run and reference at the same places of the way.
    """
    time, pose, reference = map(np.asarray, (run.time, run.pose, run.reference))
    moving = np.flatnonzero(np.any(np.diff(reference, axis=0) != 0, axis=1))
    period = float(time[1] - time[0])
    most = min(round(LONGEST / period), len(time) - 1)
    # After the last sample it stays.
    going_on = np.concatenate([pose, np.repeat(pose[-1:], most, axis=0)])

    def later(lag: int) -> Float[np.ndarray, "samples 2"]:
        return going_on[lag : lag + len(pose)]

    def square(lag: int) -> float:
        off = later(lag) - reference
        return float(np.vdot(off, off))

    first = min(range(0, most + 1, _COARSE), key=square)
    lag = min(range(max(first - _COARSE, 0), min(first + _COARSE, most) + 1), key=square)
    return InSpace(
        lag=lag * period,
        time=time,
        reference=reference,
        pose=later(lag),
        arrival=float(time[moving[-1] + 1]) if moving.size else 0.0,
    )
