"""What a tuning is predicted to do: random legs and manoeuvres simulated before and after."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from scdpr_jax.legs.leg import Leg
from scdpr_jax.legs.measures import LegMeasures
from scdpr_jax.legs.share import share, worse
from scdpr_jax.robot.fields import si


@dataclasses.dataclass(frozen=True)
class Metrics:
    """What a manoeuvre under control comes to."""

    residual_vibration: float = dataclasses.field(metadata=si("m"))
    """Peak to peak of $x_e$ once the commanded reference has ended [m]."""
    resting_error: float = dataclasses.field(metadata=si("m"))
    """Distance from the last commanded position to where the end-effector rests [m]."""
    largest_error: float = dataclasses.field(metadata=si("m", r"\varepsilon_e"))
    """Largest error against the commanded (shaped) reference, Eq. (26) [m]."""
    rms_error: float = dataclasses.field(metadata=si("m", r"\varepsilon_e"))
    """Root mean square of it until the reference ends [m]."""
    largest_original_error: float = dataclasses.field(metadata=si("m", r"\varepsilon_e"))
    """Largest error against the reference before shaping, Eq. (26) [m]."""
    largest_voltage: float = dataclasses.field(metadata=si("V", "V"))
    """Largest command of either drive [V]."""
    saturation: float = dataclasses.field(metadata=si("1"))
    """Share of the samples at which a drive is saturated [1]."""

    @classmethod
    def of(cls, measures: LegMeasures) -> "Metrics":
        """The metrics of a leg.

        Args:
            measures: Its measures.

        Returns:
            Those of them that a tuning keeps.
        """
        names = (field.name for field in dataclasses.fields(cls))
        return cls(**{name: float(getattr(measures, name)) for name in names})


@dataclasses.dataclass(frozen=True, eq=False)
class Prediction:
    """A manoeuvre simulated before and after tuning."""

    name: str
    """The manoeuvre, for a table."""
    before: Metrics
    """With the PD of Eq. (25) alone."""
    after: Metrics
    """With the tuned gains and the shaper."""
    run_before: Leg | None = None
    """Traces before; None in a tuning that was read from a file."""
    run_after: Leg | None = None
    """Traces after; None in a tuning that was read from a file."""


@dataclasses.dataclass(frozen=True, eq=False)
class LegsOutcome:
    """What random legs come to, under one command law or several."""

    vibration: Float[np.ndarray, "*laws legs"] = dataclasses.field(metadata=si("m"))
    """Peak to peak of $x_e$ after each leg [m]."""
    resting_error: Float[np.ndarray, "*laws legs"] = dataclasses.field(metadata=si("m"))
    """Distance from the target to where the end-effector rests [m]."""

    def map(self, function: Callable[[np.ndarray], np.ndarray]) -> "LegsOutcome":
        """The same of other legs, or in another shape.

        Args:
            function: From the numbers of each kind to those.

        Returns:
            The outcome.
        """
        return LegsOutcome(function(self.vibration), function(self.resting_error))


@dataclasses.dataclass(frozen=True, eq=False)
class PredictedLegs:
    """Random legs over the workspace on robots as they might be, before and after tuning."""

    before: LegsOutcome
    """With the PD of Eq. (25) and the plain profile."""
    after: LegsOutcome
    """With the tuned gains and the shapers."""
    robots: int
    """How many robots the legs were shared out to, one after the other."""
    planned: LegsOutcome | None = None
    """The first ones of them as planned for the fitted robot; None if none was."""

    @property
    def planned_share(self) -> float:
        """What is left of the vibration where legs are planned, geometric mean [1]."""
        count = 0 if self.planned is None else len(self.planned.vibration)
        if not count:
            return math.nan
        return float(share(self.planned.vibration, self.before.vibration[:count]))

    def __len__(self) -> int:
        return len(self.after.vibration)

    @property
    def share(self) -> float:
        """What is left of the vibration, geometric mean, see `scdpr_jax.legs.share` [1]."""
        return float(share(self.after.vibration, self.before.vibration))

    @property
    def worst_share(self) -> float:
        """The share of the robot that is left with most [1]."""
        after, before = self.after.vibration, self.before.vibration
        return max(
            float(share(after[k :: self.robots], before[k :: self.robots]))
            for k in range(self.robots)
        )

    @property
    def worse(self) -> float:
        """Share of the legs that shake more than before [1]."""
        return float(worse(self.after.vibration, self.before.vibration))
