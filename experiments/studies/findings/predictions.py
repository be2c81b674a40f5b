"""How well the runs that were held out are predicted."""

import dataclasses
import math

import numpy as np

from experiments.page.number_text import percent, plain
from identification.fit.comparison import Comparison
from identification.result.estimate import Estimate
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.quantities import value
from scdpr_jax.robot.state import pose


@dataclasses.dataclass(frozen=True)
class Prediction:
    """How well a held-out run was predicted."""

    run: str
    """Name of the run."""
    error: float = dataclasses.field(metadata=si("m"))
    """Root mean square distance from the measured positions [m]."""
    largest: float = dataclasses.field(metadata=si("m"))
    """Largest distance [m]."""
    motion: float = dataclasses.field(metadata=si("m"))
    """Largest extent of the measured motion [m]."""

    @property
    def share(self) -> float:
        """Error over motion [1]; infinite for a run that didn't move."""
        return self.error / self.motion if self.motion > 0 else math.inf


def prediction(comparison: Comparison, *, radius: float) -> Prediction:
    """How far a simulation is from what was measured.

    Where the camera saw the end-effector that counts; elsewhere the encoders do, whose
    turns are taken as path along the cable.

    Args:
        comparison: The run.
        radius: Effective radius of the driver pulleys [m].

    Returns:
        Its errors.
    """
    measured, simulated = pose(comparison.measured), pose(comparison.simulated)
    seen = np.all(np.isfinite(measured), axis=1)
    if not np.any(seen):
        measured, simulated = (
            radius * angle for angle in (comparison.measured_angle, comparison.simulated_angle)
        )
        seen = np.all(np.isfinite(measured), axis=1)
    distance = np.linalg.norm(measured[seen] - simulated[seen], axis=1)
    return Prediction(
        run=comparison.name,
        error=float(np.sqrt(np.mean(np.square(distance)))),
        largest=float(distance.max()),
        motion=float(np.linalg.norm(np.ptp(measured[seen], axis=0))),
    )


def predictions(estimate: Estimate) -> tuple[Prediction, ...]:
    """How well the held-out runs were predicted.

    Args:
        estimate: The estimate.

    Returns:
        One for each held-out run.
    """
    radius = float(value(estimate.robot, "effective_radius"))
    return tuple(prediction(run, radius=radius) for run in estimate.comparisons if run.held_out)


def prediction_sentence(held_out: Prediction) -> str:
    """A prediction's error, in words.

    Args:
        held_out: The prediction.

    Returns:
        The sentence.
    """
    share = ""
    if math.isfinite(held_out.share):
        share = f", {percent(held_out.share)} of its motion"
    return (
        f"Run {held_out.run}, which was not fitted, is predicted to "
        f"{plain(1e3 * held_out.error)} mm rms{share} of {plain(1e3 * held_out.motion, 3)} mm; "
        f"at the worst to {plain(1e3 * held_out.largest)} mm."
    )
