"""Robots as they might be: drawn from what a fit says about its parameters."""

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float

from identification.campaign.quantities import parse_quantity
from identification.fit.unknowns.unknowns import PER_SETTING
from identification.judge.uncertainty import ParameterEstimate
from identification.result.fitted_robot import FittedRobot
from scdpr_jax.legs.draws import NormalErrors
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import EVERY_QUANTITY, replace


def draw(
    fitted: FittedRobot, settings: tuple[float, ...], *, count: int, seed: int
) -> list[Robot]:
    r"""Samples of a fitted robot at each of some nominal pretensions.

    Errors are normal with the fit's covariance. A quantity whose error isn't known keeps its
    value. All settings of a sample share what doesn't belong to one.

    Args:
        fitted: The fitted robot.
        settings: Nominal pretensions [N]; one that wasn't fitted has the effective
            pretension of the nearest that was, in proportion, as $f \propto \sqrt{T}$ holds.
        count: How many samples.
        seed: Of the random numbers.

    Returns:
        The robots: samples by settings.
    """
    samples = _errors(fitted).draw(count, seed=seed)
    return [robot for row in samples for robot in _at_settings(fitted, row, settings)]


def draws_of(
    fitted: FittedRobot, *, count: int = 4, seed: int = 1
) -> Callable[[float], Sequence[Robot]]:
    """Samples of a fitted robot at whatever setting is asked for, the same ones at each.

    Args:
        fitted: The fitted robot.
        count: How many samples.
        seed: Of the random numbers.

    Returns:
        From a nominal pretension [N] to the robots.
    """
    return lambda setting: draw(fitted, (setting,), count=count, seed=seed)


def at_settings(fitted: FittedRobot, settings: tuple[float, ...]) -> list[Robot]:
    """The fitted robot itself at each of some nominal pretensions.

    Args:
        fitted: The fitted robot.
        settings: Nominal pretensions [N], as `draw` takes them.

    Returns:
        The robots.
    """
    return _at_settings(fitted, _errors(fitted).values, settings)


def nominal_settings(fitted: FittedRobot) -> tuple[float, ...]:
    """The nominal pretensions that a robot was fitted at.

    Args:
        fitted: The fitted robot.

    Returns:
        The settings, ascending [N].
    """
    return tuple(sorted(_newtons(label) for label in fitted.settings))


def _rows(fitted: FittedRobot) -> list[ParameterEstimate]:
    names = {each.name for each in EVERY_QUANTITY}
    return [row for row in fitted.parameters if row.name in names]


def _errors(fitted: FittedRobot) -> NormalErrors:
    """The robot's quantities, their errors correlated where the fit says so."""
    rows = _rows(fitted)
    labels = [row.label for row in rows]
    matrix = np.eye(len(rows))
    if fitted.correlation is not None:
        fit = [row.label for row in fitted.estimated]
        order = [labels.index(label) for label in fit if label in labels]
        kept = [k for k, label in enumerate(fit) if label in labels]
        matrix[np.ix_(order, order)] = fitted.correlation[np.ix_(kept, kept)]
    return NormalErrors(
        names=tuple(row.name for row in rows),
        values=np.asarray([row.value for row in rows], dtype=float),
        sigma=np.asarray([row.sigma if np.isfinite(row.sigma) else 0.0 for row in rows]),
        correlation=matrix,
    )


def _at_settings(
    fitted: FittedRobot, values: Float[np.ndarray, " rows"], settings: tuple[float, ...]
) -> list[Robot]:
    pairs = list(zip(_rows(fitted), values.tolist(), strict=True))
    common = replace(
        fitted.robot, {row.name: number for row, number in pairs if row.name != PER_SETTING}
    )
    tensions = {row.setting: number for row, number in pairs if row.name == PER_SETTING}
    return [replace(common, {PER_SETTING: _tension(tensions, setting)}) for setting in settings]


def _tension(fitted: dict[str | None, float], setting: float) -> float:
    if None in fitted:
        return fitted[None]
    effective = {_newtons(label): tension for label, tension in fitted.items() if label}
    nearest = min(effective, key=lambda nominal: abs(np.log(nominal / setting)))
    return effective[nearest] * setting / nearest


def _newtons(label: str) -> float:
    return parse_quantity(label, unit="N", name="setting")
