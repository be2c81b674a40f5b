"""Where a marker was last, and how fast."""

import dataclasses

import numpy as np
from jaxtyping import Float64

_SHORT_LOSS = 8  # pictures: what is hidden for longer is looked for everywhere
_MISSING = np.full(2, np.nan)


@dataclasses.dataclass
class Trail:
    """Where a marker was last, while a video is being read: the one thing that changes."""

    pixel: Float64[np.ndarray, " 2"] = dataclasses.field(default_factory=_MISSING.copy)
    """Where it was last [px]."""
    mean_velocity: Float64[np.ndarray, " 2"] = dataclasses.field(default_factory=_MISSING.copy)
    """How fast it was in the mean since the picture before; NaN if that isn't known [px/s]."""
    velocity: Float64[np.ndarray, " 2"] = dataclasses.field(default_factory=lambda: np.zeros(2))
    """How fast it was then [px/s]."""
    time: float = 0.0
    """When that was [s]."""
    missed: int = 0
    """Pictures since in which it wasn't seen."""

    @property
    def is_known(self) -> bool:
        """Whether it was ever seen, and not long ago."""
        return bool(np.isfinite(self.pixel[0])) and self.missed <= _SHORT_LOSS

    def velocities(
        self, pixel: Float64[np.ndarray, " 2"], time: float
    ) -> tuple[Float64[np.ndarray, " 2"], Float64[np.ndarray, " 2"]]:
        """How fast it is at its next place, had its acceleration been constant since.

        Args:
            pixel: The place [px].
            time: When it is there [s].

        Returns:
            Its mean velocity since the place before, and the one there [px/s].
        """
        if not np.isfinite(self.pixel[0]) or self.missed > 1 or time <= self.time:
            return _MISSING, np.zeros(2)
        mean = (pixel - self.pixel) / (time - self.time)
        change = mean - self.mean_velocity
        return mean, mean + (0.5 * change if np.isfinite(change[0]) else 0.0)

    def moved_to(self, pixel: Float64[np.ndarray, " 2"], time: float) -> None:
        """Take note of where it is now."""
        self.mean_velocity, self.velocity = self.velocities(pixel, time)
        self.pixel, self.time, self.missed = pixel, time, 0
