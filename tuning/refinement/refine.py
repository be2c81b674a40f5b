r"""A robot corrected by logged legs: with the fit as prior, and tried on legs left out.

What is lowered is the sum of squares of

$$ \frac{q(\theta) - q_{seen}}{\sigma\sqrt{d}}, \qquad
   \frac{\bar V(\theta) - \bar V_{told}}{\sigma_V}, \qquad \frac{\theta}{w} $$

over frames of the camera, intervals of the drives' motion, and corrections $\theta$ with their
widths; $d$ discounts frames, see `tuning.refinement.misfit`.

A correction is kept only if it foretells legs that it hasn't seen better than the fit does.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from scdpr_jax.numerics.levenberg_marquardt import Stopping, minimise
from scdpr_jax.numerics.merit import SumOfSquares
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import quantity, value
from tuning.refinement.corrections import CORRECTIONS, lowest_shares, with_corrections
from tuning.refinement.logged_leg import LoggedLeg
from tuning.refinement.misfit import residuals, seen
from tuning.refinement.replay import NUISANCES, Replay

START = np.array([2e-4, 2e-3])
"""Standard deviations of where a leg was seen to start: place [m] and slope [1]."""
STOPPING = Stopping(steps=20, rejections=8, saving=1e-4, share=0.0)


@dataclasses.dataclass(frozen=True)
class Corrected:
    """A corrected quantity."""

    name: str
    """Its name."""
    unit: str
    """Its unit."""
    before: float
    """As it was fitted."""
    after: float
    """As it is now."""
    sigma: float
    """Standard deviation of what it is now, as far as the model is right."""


@dataclasses.dataclass(frozen=True)
class LegMisfit:
    """How far from a leg a robot is: by the camera, root mean square over its noise."""

    name: str
    """The leg."""
    before: float = dataclasses.field(metadata=si("1"))
    """The robot as it was fitted."""
    after: float = dataclasses.field(metadata=si("1"))
    """The robot as it is now."""
    foretold: float = dataclasses.field(metadata=si("1"))
    """The robot that the other legs make; NaN where there is none."""


@dataclasses.dataclass(frozen=True, eq=False)
class Refined:
    """What logged legs make of a robot."""

    robot: Robot
    """The corrected robot."""
    corrected: tuple[Corrected, ...]
    """What of it is corrected."""
    legs: tuple[LegMisfit, ...]
    """The legs that it was corrected by."""

    @property
    def is_tried(self) -> bool:
        """Whether legs could be left out to try it on."""
        return len(self.legs) > 1

    @property
    def helps(self) -> bool:
        """Whether legs that a correction hasn't seen are nearer to it than to the fit."""
        if not self.is_tried:
            return self.legs[0].after < self.legs[0].before
        return _mean([own.foretold for own in self.legs]) < _mean(
            [own.before for own in self.legs]
        )


def refine(robot: Robot, legs: Sequence[LoggedLeg]) -> Refined:
    """A robot corrected by logged legs.

    Args:
        robot: The fitted robot, with exact friction.
        legs: The legs, one at least.

    Returns:
        The corrected robot, and how it foretells legs left out.

    Raises:
        ValueError: If there is no leg.
        FloatingPointError: If a leg can't be replayed.
    """
    if not legs:
        raise ValueError("`legs` is empty, expected a logged leg at least. Name a run.")
    replays = [Replay(robot, leg) for leg in legs]
    point, sigma = _solved(replays)
    shares = point[: len(CORRECTIONS)]
    as_fitted = np.zeros_like(shares)
    misfits = []
    for number, replay in enumerate(replays):
        others = replays[:number] + replays[number + 1 :]
        blind = _solved(others)[0][: len(CORRECTIONS)] if others else None
        misfits.append(
            LegMisfit(
                replay.leg.name,
                _misfit(replay, as_fitted),
                _misfit(replay, shares),
                np.nan if blind is None else _misfit(replay, blind),
            )
        )
    corrected = with_corrections(robot, shares)
    return Refined(
        corrected,
        tuple(
            Corrected(
                own.name,
                quantity(own.name).unit,
                float(value(robot, own.name)),
                float(value(corrected, own.name)),
                sigma=(float(value(corrected, own.name)) if own.relative else 1.0)
                * float(own.width * deviation),
            )
            for own, deviation in zip(CORRECTIONS, sigma, strict=True)
        ),
        tuple(misfits),
    )


def _solved(
    replays: Sequence[Replay],
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " corrections"]]:
    """Corrections and starts that fit legs best, and the corrections' standard deviations."""
    count = len(CORRECTIONS)
    lower = np.concatenate(
        [lowest_shares(replays[0].robot), np.full(NUISANCES * len(replays), -np.inf)]
    )
    start = np.zeros(lower.size)
    found = minimise(lambda point: _sum(replays, point), start, stopping=STOPPING, lower=lower)
    if found.ended == "infeasible":
        raise FloatingPointError(
            "the legs can't be replayed by the fitted robot: its motion isn't finite. Are they "
            "of this rig?"
        )
    covariance = np.linalg.inv(found.normal.matrix)
    return found.point, np.sqrt(np.diag(covariance)[:count])


def _sum(replays: Sequence[Replay], point: Float[np.ndarray, " n"]) -> SumOfSquares:
    """The misfit; starts are counted in their standard deviations, as corrections are."""
    count = len(CORRECTIONS)
    shares, starts = point[:count], point[count:].reshape(-1, NUISANCES)
    values, rows = [point], [np.eye(point.size)]
    for number, (replay, start) in enumerate(zip(replays, starts, strict=True)):
        made = replay(shares, START * start)
        own, slope = residuals(replay, made)
        wide = np.zeros((own.size, point.size))
        wide[:, :count] = slope[:, :count]
        first = count + NUISANCES * number
        wide[:, first : first + NUISANCES] = slope[:, count:] * START
        values.append(own)
        rows.append(wide)
    return SumOfSquares(np.concatenate(values), np.concatenate(rows))


def _misfit(replay: Replay, shares: Float[np.ndarray, " n"]) -> float:
    """Of a corrected robot whose start is as it was seen."""
    away, _ = seen(replay, replay(shares, np.zeros(NUISANCES)))
    return float(np.sqrt(np.nanmean(np.square(away))))


def _mean(misfits: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(misfits))))
