"""A robot as a fit knows it: values with their errors, and how these hang together."""

import dataclasses
from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from identification.fit.problem import Problem
from identification.fit.run_sums import RunSums, assemble
from identification.fit.unknowns.unknowns import PER_SETTING, Unknowns, decode, lower_bound
from identification.judge.uncertainty import (
    DOES_NOT_FIT,
    Covariance,
    ParameterEstimate,
    covariance,
    interval95,
    is_undetermined,
    judge,
)
from scdpr_jax.numerics.levenberg_marquardt import Minimum, free_unknowns
from scdpr_jax.provenance import UNKNOWN, Provenance
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import QUANTITIES, quantity, replace, value
from scdpr_jax.robot.stated.ranges import SETTING_TOLERANCE


@dataclasses.dataclass(frozen=True)
class Residual:
    """What a fit leaves of a channel of a run."""

    channel: str
    """Name of the column."""
    rms: float
    """Root mean square of measurement minus simulation [rad or m]."""
    noise_sigma: float
    """Standard deviation of the sensor's noise [rad or m]."""
    is_noise: bool
    """Whether the residual may be the sensor's noise alone."""


@dataclasses.dataclass(frozen=True, eq=False)
class FittedRobot:
    """A robot as a fit knows it, which is what `parameters.json` holds of one."""

    robot: Robot
    """The robot with the estimated values, the pretension being the first setting's."""
    parameters: tuple[ParameterEstimate, ...]
    """Every named quantity, estimated or fixed."""
    correlation: Float[np.ndarray, "n n"] | None = dataclasses.field(metadata=si("1"))
    """Correlation of the estimated ones, in their order; None where it isn't known [1]."""
    residuals: tuple[Residual, ...] = ()
    """What the fit leaves of each channel of each run."""
    provenance: Provenance = UNKNOWN
    """Where it comes from."""

    @property
    def estimated(self) -> tuple[ParameterEstimate, ...]:
        """The parameters that were estimated, in their order."""
        return tuple(p for p in self.parameters if p.status != "fixed")

    @property
    def fits(self) -> bool:
        """Whether the fit that the parameters come from hasn't failed."""
        return all(p.status != DOES_NOT_FIT for p in self.parameters)

    @property
    def settings(self) -> tuple[str, ...]:
        """The nominal pretensions that have an effective one."""
        return tuple(p.setting for p in self.parameters if p.name == PER_SETTING and p.setting)

    def of_setting(self, label: str) -> Robot:
        """The robot at a nominal pretension.

        Args:
            label: The setting as the logs name it, "350 N".

        Returns:
            The robot with that setting's effective pretension.

        Raises:
            ValueError: If no fitted run had that setting.
        """
        near = next((each for each in self.settings if _is_near(each, label)), label)
        for parameter in self.parameters:
            if parameter.name == PER_SETTING and parameter.setting in (near, None):
                return replace(self.robot, {PER_SETTING: parameter.value})
        raise ValueError(
            f"`setting`: no effective pretension for {label!r}, got "
            f"{', '.join(self.settings) or 'none'} in the parameters [N]. Name one of these, "
            "or identify from runs at that setting."
        )


def _is_near(setting: str, label: str) -> bool:
    """Whether two labels, "350 N", are the same setting as a controller reads it."""
    numbers = [float(text.removesuffix("N")) for text in (setting, label) if text.endswith("N")]
    return len(numbers) == 2 and abs(numbers[0] - numbers[1]) <= SETTING_TOLERANCE * numbers[0]


def fitted_robot(
    problem: Problem, minimum: Minimum, sums: Mapping[int, RunSums]
) -> FittedRobot:
    """The robot at a fit's minimum, with errors by the minimum's curvature and scores.

    Args:
        problem: The problem.
        minimum: Its minimum.
        sums: What each fitted run adds there, by its number.

    Returns:
        The robot, every quantity judged; without residuals.
    """
    unknowns, point = problem.unknowns, minimum.point
    _, scores = assemble(unknowns, sums, shared=True)
    errors = covariance(
        minimum.normal.matrix,
        scores,
        free_unknowns(minimum.normal, point, unknowns.lower()),
        otherwise=problem.otherwise(point).matrix,
    )
    opened = np.flatnonzero(unknowns.opened)
    parameters = [_parameter(problem, minimum, errors, index) for index in opened.tolist()]
    robot = replace(problem.prior, {p.name: p.value for p in reversed(parameters)})
    return FittedRobot(
        robot,
        (*parameters, *_fixed(robot, unknowns)),
        errors.correlation[np.ix_(opened, opened)],
    )


def _parameter(
    problem: Problem, minimum: Minimum, errors: Covariance, index: int
) -> ParameterEstimate:
    """An estimated quantity, from its value and standard error as the fit holds them."""
    name, setting = problem.unknowns.shared[index]
    encoded, sigma = float(minimum.point[index]), float(errors.sigma[index])
    degrees_of_freedom = float(errors.degrees_of_freedom[index])
    at_bound = encoded <= lower_bound(name)
    kind, number = quantity(name), decode(name, encoded)
    if is_undetermined(name, number, sigma) and not at_bound:
        # What no run shows is what it was taken to be, not where a search left it.
        number, sigma = float(value(problem.prior, name)), np.inf
    # The logarithm's standard error is relative.
    sigma *= number if kind.positive else 1.0
    return ParameterEstimate(
        name=name,
        setting=setting,
        value=number,
        unit=kind.unit,
        sigma=sigma,
        interval95=interval95(name, number, sigma, degrees_of_freedom),
        status=judge(name, number, sigma, at_bound=at_bound),
        degrees_of_freedom=degrees_of_freedom,
    )


def _fixed(robot: Robot, unknowns: Unknowns) -> list[ParameterEstimate]:
    """The quantities that the fit didn't open, as they are."""
    opened = {name for name, _ in unknowns.opened_names}
    numbers = {q: float(value(robot, q.name)) for q in QUANTITIES if q.name not in opened}
    return [
        ParameterEstimate(
            name=kind.name,
            setting=None,
            value=number,
            unit=kind.unit,
            sigma=0.0,
            interval95=(number, number),
            status="fixed",
        )
        for kind, number in numbers.items()
    ]
