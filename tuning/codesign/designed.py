"""A design and what it comes to at the controllers' own rate."""

import dataclasses
from collections.abc import Sequence

import jax
import numpy as np
from jaxtyping import Float

from scdpr_jax.legs.measures import LegMeasures
from tuning.codesign.models import Models
from tuning.codesign.outcomes import grid, run
from tuning.codesign.tail import value_at_risk
from tuning.codesign.unknowns import Law, command

SHARE = 0.1
"""Share of the models, the worst of them, that a design is judged by [1]."""
PERIOD = 1e-3
"""Sample period of the controllers [s]."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Designed:
    """A design and what it comes to."""

    law: Law
    """Gains, impulses and leg."""
    move_time: float
    """Time from the reference's begin to its end, the shaper included [s]."""
    costs: Float[np.ndarray, " models"]
    """Every model's cost under it, at the controllers' own rate [1]."""
    measures: LegMeasures
    """What each leg comes to, in numbers."""
    point: Float[np.ndarray, " n"] | None = None
    """Its flat unknowns; None where it comes from elsewhere."""

    def __repr__(self) -> str:
        controller = self.law.controller
        return (
            f"Designed: moves of {self.move_time:.4g} s, PD of "
            f"{float(controller.proportional_gain):.4g} V/rad and "
            f"{float(controller.derivative_gain):.4g} V s/rad, "
            f"{self.law.shaper.times.size} impulses; worst tenth vibrates "
            f"{1e3 * self.vibration:.3g} mm"
        )

    @property
    def cost(self) -> float:
        """Mean cost of the worst `SHARE` of the models [1]."""
        return value_at_risk(self.costs, SHARE)

    @property
    def vibration(self) -> float:
        """Mean vibration of the worst `SHARE` of the models, peak to peak [m]."""
        return value_at_risk(np.asarray(self.measures.residual_vibration), SHARE)

    def keeps_voltage(self, limit: float) -> bool:
        """Whether no model's drives come to their limit.

        Args:
            limit: Largest command [V].

        Returns:
            Whether none does.
        """
        return bool(np.max(self.measures.largest_voltage) < limit)


def evaluate(models: Models, law: Law, *, longest: float | None = None) -> Designed:
    """What a design comes to at the controllers' own rate.

    Args:
        models: The models.
        law: The design.
        longest: Longest move of all that will be looked at [s], so that one compilation
            serves them; None for this one.

    Returns:
        The design with what every model comes to.
    """
    time = float(law.leg_time + law.shaper.duration)
    on = grid(longest or time, PERIOD)
    outcome = run(models, _told(law, on=on), on)
    return Designed(law, time, np.asarray(outcome.cost), outcome.measures)


def ranked(designs: Sequence[Designed], models: Models) -> list[Designed]:
    """Designs by cost, those that keep the drives' limit before all others.

    Args:
        designs: The designs, evaluated on the same models.
        models: These.

    Returns:
        The designs, the best first.
    """
    limit = float(np.min(models.ensemble.robot.drive.voltage_limit))
    return sorted(designs, key=lambda one: (not one.keeps_voltage(limit), one.cost))


_told = jax.jit(command, static_argnames="on")
