"""Robots as they might be: drawn from what a fit says about its parameters."""

import numpy as np
from jaxtyping import Float

from experiments.files.parameters_file import FittedRobot
from identification.campaign.quantities import parse_quantity
from identification.fit.unknowns.unknowns import PER_SETTING
from scdpr_jax.robot.parameters import EVERY_QUANTITY, Robot, quantity, replace


def draw(
    fitted: FittedRobot, settings: tuple[float, ...], *, count: int, seed: int
) -> list[Robot]:
    r"""Samples of a fitted robot at each of some nominal pretensions.

    Errors are normal with the fit's covariance, those of positive quantities in their
    logarithm: $p e^{\sigma z / p}$. A quantity whose error isn't known keeps its value. All
    settings of a sample share what doesn't belong to one.

    Args:
        fitted: The fitted robot.
        settings: Nominal pretensions [N]; one that wasn't fitted has the effective
            pretension of the nearest that was, in proportion, as $f \propto \sqrt{T}$ holds.
        count: How many samples.
        seed: Of the random numbers.

    Returns:
        The robots: samples by settings.
    """
    known = {one.name for one in EVERY_QUANTITY}
    rows = [row for row in fitted.parameters if row.name in known]
    names = [row.name if row.setting is None else f"{row.name} {row.setting}" for row in rows]
    random = np.random.default_rng(seed)
    errors = _errors(fitted, names, random, count)
    robots = []
    for sample in errors:
        values = {
            (row.name, row.setting): _moved(row.name, row.value, (row.sigma or 0.0) * error)
            for row, error in zip(rows, sample, strict=True)
        }
        common = replace(
            fitted.robot,
            {name: value for (name, _), value in values.items() if name != PER_SETTING},
        )
        tensions = {label: v for (name, label), v in values.items() if name == PER_SETTING}
        robots += [
            replace(common, {PER_SETTING: _tension(tensions, setting)}) for setting in settings
        ]
    return robots


def nominal_settings(fitted: FittedRobot) -> tuple[float, ...]:
    """The nominal pretensions that a robot was fitted at.

    Args:
        fitted: The fitted robot.

    Returns:
        The settings, ascending [N].
    """
    return tuple(sorted(_newtons(label) for label in fitted.settings))


def _errors(
    fitted: FittedRobot, names: list[str], random: np.random.Generator, count: int
) -> Float[np.ndarray, "count names"]:
    """Errors in standard errors: correlated where the fit says so."""
    matrix = np.eye(len(names))
    if fitted.correlation is not None:
        order = [names.index(n) for n in fitted.correlation.names if n in names]
        kept = [k for k, n in enumerate(fitted.correlation.names) if n in names]
        own = np.asarray(fitted.correlation.matrix)[np.ix_(kept, kept)]
        matrix[np.ix_(order, order)] = own
    # Correlations that a file rounds may miss being positive by as much.
    values, vectors = np.linalg.eigh(matrix)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return random.standard_normal((count, len(names))) @ root.T


def _moved(name: str, value: float, error: float) -> float:
    about = quantity(name)
    if about.signed:
        return value + error
    return value * np.exp(error / value) if value > 0 else max(value + error, 0.0)


def _tension(fitted: dict[str | None, float], setting: float) -> float:
    if None in fitted:
        return fitted[None]
    known = {_newtons(label): tension for label, tension in fitted.items() if label}
    nearest = min(known, key=lambda one: abs(np.log(one / setting)))
    return known[nearest] * setting / nearest


def _newtons(label: str) -> float:
    return parse_quantity(label, unit="N", name="setting")
