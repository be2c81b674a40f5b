"""Random legs before and after, as `tuning.json` holds them."""

from typing import Annotated, Any

import numpy as np
import pydantic

from scdpr_jax.numerics.json_file import JsonObject
from tuning.result.prediction import LegsOutcome, PredictedLegs

Length = Annotated[float, pydantic.Field(ge=0, le=10.0)]
"""A length within a robot [m]."""


def legs_document(legs: PredictedLegs) -> dict[str, Any]:
    """Random legs as a part of a file.

    Args:
        legs: The legs.

    Returns:
        What they come to, and every leg of it [m].
    """
    return {
        "share": legs.share,
        "worst_share": legs.worst_share,
        "worse": legs.worse,
        "robots": legs.robots,
        "before": _outcome(legs.before),
        "after": _outcome(legs.after),
        "planned": None if legs.planned is None else _outcome(legs.planned),
    }


def _outcome(outcome: LegsOutcome) -> dict[str, list[float]]:
    return {
        "residual_vibration": outcome.vibration.tolist(),
        "resting_error": outcome.resting_error.tolist(),
    }


class _Outcome(JsonObject):
    residual_vibration: list[Length]
    resting_error: list[Length]

    def build(self) -> LegsOutcome:
        return LegsOutcome(np.asarray(self.residual_vibration), np.asarray(self.resting_error))


class LegsInFile(JsonObject):
    """Random legs before and after."""

    robots: Annotated[int, pydantic.Field(ge=1)]
    before: _Outcome
    after: _Outcome
    planned: _Outcome | None = None

    @pydantic.model_validator(mode="after")
    def _is_of_the_same_legs(self) -> "LegsInFile":
        sides = (self.before, self.after)
        counts = {len(row) for s in sides for row in (s.residual_vibration, s.resting_error)}
        if len(counts) != 1 or min(counts) < self.robots:
            raise ValueError(
                f"got lists of {sorted(counts)} legs for {self.robots} robots, expected one "
                "length, and a leg for each robot at least"
            )
        if self.planned is not None:
            rows = (self.planned.residual_vibration, self.planned.resting_error)
            lengths = {len(row) for row in rows}
            if len(lengths) != 1 or not 0 < min(lengths) <= max(counts):
                raise ValueError(
                    f"got lists of {sorted(lengths)} planned legs of {max(counts)}, expected "
                    "one length, and no more than there are legs"
                )
        return self

    def build(self) -> PredictedLegs:
        """The legs."""
        planned = None if self.planned is None else self.planned.build()
        return PredictedLegs(self.before.build(), self.after.build(), self.robots, planned)
