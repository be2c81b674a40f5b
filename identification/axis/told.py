"""What an axis's log tells of its parameters, by the rank of its open loop's derivatives."""

import numpy as np
from jaxtyping import Float

from identification.sensitivity.combinations import Combination, combinations


def told(
    names: tuple[str, ...],
    values: Float[np.ndarray, " n"],
    jacobian: Float[np.ndarray, "samples m"],
    *,
    plausible: Float[np.ndarray, " n"],
    noise: float,
    motion: float,
) -> tuple[Combination, ...]:
    """The combinations of parameters that a log tells, and those that it doesn't.

    Args:
        names: The parameters.
        values: Their values [SI].
        jacobian: Derivatives of the open loop's positions with respect to them, and to the
            start velocities behind them.
        plausible: What is plausible of each parameter [SI].
        noise: Standard deviation of the positions' noise [m or rad].
        motion: Root mean square of the motion [m or rad].

    Returns:
        From the best to the worst told.
    """
    law, starts = jacobian[:, : len(values)] * plausible, jacobian[:, len(values) :]
    if starts.shape[1]:
        # What a start velocity can do as well, the parameter doesn't tell.
        law = law - starts @ np.linalg.lstsq(starts, law, rcond=None)[0]
    least = max(noise, np.finfo(float).eps * motion)
    return combinations(
        law.T @ law / least**2,
        tuple((name, None) for name in names),
        motion=np.sqrt(len(jacobian)) * motion / least,
    )


def one_way(
    names: tuple[str, ...], jacobian: Float[np.ndarray, "samples m"], direction: int
) -> Float[np.ndarray, "samples m"]:
    """Derivatives of an axis that never turns round: friction and offset are one force to it.

    At rest both are an inequality, which tells no value. A search may end on its edge, where
    the axis just doesn't creep, and derivatives there take the edge for something told.

    Args:
        names: The parameters.
        jacobian: Derivatives with respect to them first.
        direction: 1 or -1 of an axis that only moves forwards or backwards, else 0.

    Returns:
        The derivatives; as they are for an axis that turns round.
    """
    if not direction:
        return jacobian
    made = jacobian.copy()
    made[:, names.index("offset")] = direction * made[:, names.index("coulomb")]
    return made


def plausible_sizes(
    names: tuple[str, ...], mass: float, *, force: float, speed: float
) -> Float[np.ndarray, " n"]:
    """What is plausible of each parameter: the force that the drive has, and what it makes.

    Args:
        names: The parameters.
        mass: The mass's value [kg or kg m²].
        force: Root mean square of the drive's force [N or N m].
        speed: Root mean square of the velocity [m/s or rad/s].

    Returns:
        Their sizes [SI].
    """
    sizes = {"mass": mass, "coulomb": force, "offset": force}
    return np.array([sizes.get(name, force / max(speed, 1e-300)) for name in names])


def sum_sigma(
    names: tuple[str, ...],
    covariance: Float[np.ndarray, "m m"],
    combined: tuple[Combination, ...],
) -> float:
    """Standard error of Coulomb friction and offset together, where no more is told.

    It is that of the direction in the plane of both that has the least error: the other one's
    is huge, and rounding would leave some of it in a sum of variances.

    Args:
        names: The parameters.
        covariance: Their covariance.
        combined: What the log tells, and what not.

    Returns:
        The standard error [N or N m]; NaN where each is told, or neither.
    """
    at = [names.index(name) for name in ("coulomb", "offset")]
    for each in combined:
        friction, offset = np.array(each.powers)[at]
        if not each.is_told and np.hypot(friction, offset) > 0.99:
            values, vectors = np.linalg.eigh(covariance[np.ix_(at, at)])
            return float(np.sqrt(max(values[0], 0.0)) * abs(vectors[:, 0]).sum())
    return float("nan")
