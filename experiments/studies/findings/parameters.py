r"""The estimated parameters in words, and the friction force $4 T \mu$ that they come to.

Friction and pretension enter the motion as a product: their estimates are correlated, and
the product is surer than either. So its interval is made with their correlation.
"""

import dataclasses
import math
from collections.abc import Mapping

from experiments.page.number_text import percent, readable_unit, rounded
from identification.fit.unknowns.unknowns import PER_SETTING
from identification.judge.uncertainty import (
    DOES_NOT_FIT,
    USUAL,
    ParameterEstimate,
    half_width,
)
from identification.result.estimate import Estimate
from scdpr_jax.robot.fields import si

FRICTION = "friction_coefficient"

COVERED = 0.997
"""Level of the interval that the truth is looked for in [1]."""


@dataclasses.dataclass(frozen=True)
class FrictionForce:
    r"""Friction of a carriage at the aligned pose, $4 T \mu$."""

    setting: str | None
    """Nominal pretension."""
    force: float = dataclasses.field(metadata=si("N"))
    """Force [N]."""
    half_width: float = dataclasses.field(metadata=si("N"))
    """Half of its 95 % interval [N]."""


def estimated(estimate: Estimate) -> tuple[ParameterEstimate, ...]:
    """The parameters that were estimated, in the order of the correlation matrix.

    Args:
        estimate: The estimate.

    Returns:
        All that aren't fixed.
    """
    return tuple(p for p in estimate.parameters if p.status != "fixed")


def friction_forces(estimate: Estimate) -> tuple[FrictionForce, ...]:
    r"""Friction force $4 T \mu$ of each setting, which the data determine best.

    Args:
        estimate: The estimate.

    Returns:
        One for each pretension setting whose friction was estimated.
    """
    free = estimated(estimate)
    names = [(parameter.name, parameter.setting) for parameter in free]
    if (FRICTION, None) not in names:
        return ()
    mu_at = names.index((FRICTION, None))
    mu, forces = free[mu_at], []
    for index, parameter in enumerate(free):
        if parameter.name != PER_SETTING or mu.value == 0:
            continue
        if not math.isfinite(parameter.sigma + mu.sigma):
            continue
        force = 4 * parameter.value * mu.value
        shares = (parameter.sigma / parameter.value, mu.sigma / mu.value)
        together = 2 * float(estimate.correlation[index, mu_at]) * shares[0] * shares[1]
        variance = shares[0] ** 2 + shares[1] ** 2 + together
        sigma = force * math.sqrt(max(variance, 0.0))
        half = half_width(sigma, 0.95, parameter.degrees_of_freedom)
        forces.append(FrictionForce(parameter.setting, force, half))
    return tuple(forces)


def covers(estimate: Estimate, truth: Mapping[str, float]) -> bool:
    """Whether every estimate's 99.7 % interval covers the truth.

    Args:
        estimate: The estimate.
        truth: True values by name [SI]; what isn't estimated isn't looked at.

    Returns:
        Whether all do.
    """
    return all(inside(p, truth[p.name]) for p in estimated(estimate) if p.name in truth)


def inside(parameter: ParameterEstimate, truth: float) -> bool:
    """Whether a parameter's 99.7 % interval covers the truth.

    Args:
        parameter: The parameter.
        truth: The true value [SI].

    Returns:
        Whether it does.
    """
    low, high = parameter.interval(COVERED)
    return low <= truth <= high


def parameter_sentence(parameter: ParameterEstimate) -> str:
    """A parameter with its interval, in words.

    Args:
        parameter: The parameter.

    Returns:
        The sentence.
    """
    setting = "" if parameter.setting is None else f" at {parameter.setting}"
    name = parameter.name.replace("_", " ").capitalize() + setting
    unit = "" if parameter.unit == "1" else f" {readable_unit(parameter.unit)}"
    if parameter.status == DOES_NOT_FIT:
        value = rounded(parameter.value, 1e-2 * abs(parameter.value))
        return f"{name}: {value}{unit} by a model that does not fit: it may be off by anything."
    if parameter.status == "unidentifiable":
        return f"{name} can't be told from these runs."
    if parameter.status == "at_bound":
        return f"{name} came to rest at its bound, {rounded(parameter.value, 0)}{unit}."
    half = parameter.half_width
    if parameter.name in USUAL and parameter.value <= half:
        most = rounded(parameter.value + half, half)
        return f"{name}: {most}{unit} at the most (95 %); the runs don't ask for any."
    relative = f", {percent(half / abs(parameter.value))}" if parameter.value else ""
    weak = "; only weakly identified" if parameter.status == "weak" else ""
    return (
        f"{name}: {rounded(parameter.value, half)} ± {rounded(half, half)}{unit} "
        f"(95 %{relative}{weak})."
    )


def friction_sentence(friction: FrictionForce) -> str:
    """A friction force with its interval, in words.

    Args:
        friction: The force.

    Returns:
        The sentence.
    """
    at = "" if friction.setting is None else f" at {friction.setting}"
    half = friction.half_width
    return (
        f"Friction force of a carriage{at}, 4Tμ: {rounded(friction.force, half)} ± "
        f"{rounded(half, half)} N (95 %)."
    )
