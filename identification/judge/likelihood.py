"""What the likelihood leaves possible: along one quantity, and drawn in all of them.

A standard error takes the misfit for a parabola. A profile follows it along one quantity, draws
from the posterior walk all of it: both may say that a quantity has one end, or none.
"""

import dataclasses

import numpy as np
from jaxtyping import Float

from scdpr_jax.robot.fields import si


@dataclasses.dataclass(frozen=True, eq=False)
class Profile:
    """The misfit along one quantity."""

    name: str
    """Name of the quantity."""
    setting: str | None
    """Nominal pretension that it belongs to."""
    values: Float[np.ndarray, " n"]
    """Where it was held, its estimate among them [SI]."""
    rise: Float[np.ndarray, " n"]
    """Rise of the misfit over that of the estimate, the others fitted anew [1]."""
    threshold: float
    """Rise at the end of a 95 % interval, by the robust standard error [1]."""

    @property
    def ends(self) -> tuple[float, float]:
        """Where the misfit passes the threshold on both sides; infinite where it doesn't."""
        at = int(np.argmin(self.rise))
        below, above = slice(at, None, -1), slice(at, None)
        return self._crossing(below, never=-np.inf), self._crossing(above, never=np.inf)

    def _crossing(self, way: slice, *, never: float) -> float:
        # The root of a parabola's rise is straight: interpolated, it needs few points.
        root = np.sqrt(np.maximum(self.rise[way], 0.0)) / np.sqrt(self.threshold)
        beyond = np.flatnonzero(root >= 1.0)
        if not beyond.size:
            return never
        pair = slice(beyond[0] - 1, beyond[0] + 1)
        return float(np.interp(1.0, root[pair], self.values[way][pair]))

    @property
    def label(self) -> str:
        """`bounded`, `one-sided` or `flat`."""
        return ("flat", "one-sided", "bounded")[sum(np.isfinite(self.ends))]


@dataclasses.dataclass(frozen=True, eq=False)
class Posterior:
    """Draws from what the logs leave possible."""

    names: tuple[tuple[str, str | None], ...]
    """Name and setting of each quantity."""
    draws: Float[np.ndarray, "chains draws quantities"]
    """Values [SI]."""
    r_hat: Float[np.ndarray, " quantities"] = dataclasses.field(metadata=si("1"))
    """Potential scale reduction of each quantity [1]."""
    effective: Float[np.ndarray, " quantities"] = dataclasses.field(metadata=si("1"))
    """Independent draws that these are worth [1]."""

    @property
    def mean(self) -> Float[np.ndarray, " quantities"]:
        """Means of the quantities [SI]."""
        return self._flat.mean(axis=0)

    @property
    def sigma(self) -> Float[np.ndarray, " quantities"]:
        """Standard deviations of the quantities [SI]."""
        return self._flat.std(axis=0)

    def interval(self, level: float = 0.95) -> Float[np.ndarray, "quantities 2"]:
        """Central intervals of the quantities.

        Args:
            level: Probability inside [1].

        Returns:
            Lower and upper ends [SI].
        """
        tails = (0.5 - level / 2, 0.5 + level / 2)
        return np.quantile(self._flat, tails, axis=0).T

    @property
    def _flat(self) -> Float[np.ndarray, "all quantities"]:
        return self.draws.reshape(-1, self.draws.shape[-1])
