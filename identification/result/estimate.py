"""What a campaign says about a robot."""

import dataclasses

import numpy as np
from jaxtyping import Float

from identification.data.circumstances import Circumstances
from identification.fit.comparison import Comparison
from identification.fit.starts import Valley
from identification.fit.unknowns.measured import MeasuredFit
from identification.fit.unknowns.models import Model
from identification.fit.unknowns.options import FitOptions
from identification.judge.identifiability import Identifiability
from identification.judge.influence import Influence
from identification.judge.uncertainty import ParameterEstimate
from identification.judge.verdict import Unexplained
from identification.result.fitted_robot import FittedRobot
from scdpr_jax.robot.parameters import Robot


@dataclasses.dataclass(frozen=True)
class Fit:
    """How an estimate came about."""

    starts: tuple[float, ...]
    """Misfit per measurement that each start ended at, before the last iterations [1]."""
    valleys: tuple[Valley, ...]
    """Every distinct minimum on the way, with its misfit."""
    iterations: int
    """Evaluations of the normal equations after the best start was chosen."""
    ended: str
    """How the last fit ended: `converged`, `stalled` at a kink, or `unfinished`."""
    misfit: float
    """Misfit per measurement, see `identification.fit.misfit`; 1 if it is only noise [1]."""
    measurements: float
    """Number of independent measurements, see `identification.data.record.readings`."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Estimate:
    """What a campaign says about a robot."""

    fitted: FittedRobot
    """The robot with its parameters and their errors."""
    circumstances: dict[str, Circumstances]
    """What was estimated of each run by itself, by the run's name."""
    comparisons: tuple[Comparison, ...]
    """Every run beside its simulation, those that were held out included."""
    fit: Fit
    """How it came about."""
    identifiability: Identifiability
    """What these logs can tell of what."""
    influence: Influence
    """Which run moves which quantity, and the bootstrap over runs."""
    unexplained: tuple[Unexplained, ...] = ()
    """Channels that this model doesn't explain, the worst first; a fit that has any failed."""
    accepted: tuple[str, ...] = ()
    """Contradictions of the sensors that the fit went on with, in words."""
    options: FitOptions = dataclasses.field(default_factory=FitOptions)
    """What the fit was asked for; `free` are the quantities of the model that it is of."""
    models: tuple[Model, ...] = ()
    """The models that were compared, the usual one first; empty where that is enough."""
    choice: int = 0
    """Which of them this estimate is of."""

    @property
    def robot(self) -> Robot:
        """The robot with the estimated values, the pretension being the first setting's."""
        return self.fitted.robot

    @property
    def parameters(self) -> tuple[ParameterEstimate, ...]:
        """Every named quantity, estimated or fixed."""
        return self.fitted.parameters

    @property
    def fits(self) -> bool:
        """Whether the model explains what was measured, as far as a model can."""
        return self.fitted.fits

    @property
    def correlation(self) -> Float[np.ndarray, "n n"]:
        """Correlation of the estimated ones, in their order [1]."""
        return self.fitted.correlation

    @property
    def lacks(self) -> tuple[str, ...]:
        """What the usual model lacks, by the choice between models."""
        return self.models[self.choice].added if self.models else ()

    @property
    def measured_fits(self) -> tuple[MeasuredFit, ...]:
        """What was measured otherwise beside what the fit makes of it, as it was given."""
        return tuple(
            MeasuredFit.of(
                number, self.of_setting(number.setting) if number.setting else self.robot
            )
            for number in self.options.measured
        )

    def of_setting(self, label: str) -> Robot:
        """The robot at a nominal pretension, see `FittedRobot.of_setting`.

        Args:
            label: The setting as the logs name it, "350 N".

        Returns:
            The robot with that setting's effective pretension.

        Raises:
            ValueError: If no fitted run had that setting.
        """
        return self.fitted.of_setting(label)

    def __repr__(self) -> str:
        predicted = sum(run.held_out for run in self.comparisons)
        lines = [
            f"Estimate from {len(self.comparisons) - predicted} runs, {predicted} predicted: "
            f"{self.fit.ended}, misfit {self.fit.misfit:.3g} a measurement"
        ]
        lines += [f"  {parameter}" for parameter in self.fitted.estimated]
        lines += [f"  the usual model lacks {what}" for what in self.lacks]
        return "\n".join(lines)
