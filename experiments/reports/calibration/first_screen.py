"""The report's first screen: what is the robot, can I trust it, what do I get."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from experiments.page.coordinates import plain_symbol
from experiments.page.number_text import percent, plain, readable_unit, short
from experiments.studies.findings.findings import Findings
from experiments.studies.findings.parameters import estimated
from experiments.studies.findings.tuning import TuningFindings
from experiments.studies.trust import Trust, trust
from identification.judge.uncertainty import ParameterEstimate
from scdpr_jax.robot.quantities import EVERY_QUANTITY
from tuning.result.prediction import LegsOutcome, PredictedLegs

_SHORT = {
    "friction_coefficient": "friction",
    "effective_pretension": "pretension",
    "drive_inertia": "drive inertia",
    "drive_damping": "drive damping",
}
_SMALL = 1e-4
"""Size below which a number is written with a power of ten."""


@dataclasses.dataclass(frozen=True)
class Quantity:
    """A line of what the robot is."""

    symbol: tuple[str, str]
    """Symbol and its index."""
    name: str
    """What it is, with its setting."""
    value: str
    """Value with its unit, or that it isn't known."""
    interval: str
    """Half of its 95 % interval; empty where nothing tells it."""
    flag: str
    """What is to be minded; empty for nothing."""


@dataclasses.dataclass(frozen=True)
class Law:
    """A line of what one gets."""

    name: str
    """The law."""
    vibration: str
    """Median of the vibration after a leg, and the worst [mm]."""
    resting_error: str
    """Median of the resting error, and the worst [mm]."""


@dataclasses.dataclass(frozen=True)
class FirstScreen:
    """Answers to the three questions that a reader comes with."""

    robot: tuple[Quantity, ...]
    """What is the robot: the paper's quantities."""
    more: int
    """How many others were estimated."""
    trust: Trust
    """Can I trust it."""
    laws: tuple[Law, ...]
    """What do I get; empty where there are no legs to tell it."""
    legs: str
    """What legs these are, or why there are none."""


def first_screen(findings: Findings) -> FirstScreen:
    """The answers.

    Args:
        findings: What a calibration comes to.

    Returns:
        The three answers.
    """
    free = estimated(findings.estimate)
    usual = [parameter for name in _SHORT for parameter in free if parameter.name == name]
    legs = None if findings.tuning is None else findings.tuning.tuning.legs
    return FirstScreen(
        tuple(map(_quantity, usual)),
        len(free) - len(usual),
        trust(findings),
        () if legs is None else _laws(legs),
        _words(findings.tuning, legs),
    )


def exported_sides(legs: PredictedLegs) -> tuple[tuple[str, LegsOutcome], ...]:
    """The laws that legs were simulated with, the paper's first.

    Args:
        legs: The legs.

    Returns:
        Names and outcomes.
    """
    sides = [("before, Eq. (25)", legs.before), ("gains and shapers", legs.after)]
    if legs.planned is not None:
        sides.append(("planned", legs.planned))
    return tuple(sides)


def _quantity(parameter: ParameterEstimate) -> Quantity:
    kind = {quantity.name: quantity for quantity in EVERY_QUANTITY}.get(parameter.name)
    half = parameter.half_width
    unit = "" if parameter.unit == "1" else f" {readable_unit(parameter.unit)}"
    name = _SHORT[parameter.name]
    size = abs(parameter.value)
    if not np.isfinite(half):
        # Nothing tells how far off it is: a hundredth is more than it is worth.
        digits, interval = 2, ""
    elif half < size:
        digits, interval = _digits(half / size), f"± {percent(half / size)}"
    else:
        digits, interval = 2, f"± {short(half, 2)}{unit}"
    text = f"{_to_digits(parameter.value, digits)}{unit}"
    return Quantity(
        plain_symbol(kind.symbol) if kind else ("", ""),
        name if parameter.setting is None else f"{name} at {parameter.setting}",
        "not told" if parameter.status == "unidentifiable" else text,
        "" if parameter.status == "unidentifiable" else interval,
        "" if parameter.status == "identified" else parameter.status.replace("_", " "),
    )


def _digits(share: float) -> int:
    """Digits that a relative error bears, two of its own; five are enough at a glance."""
    return int(min(max(2 - np.floor(np.log10(share)), 2), 5))


def _to_digits(value: float, digits: int) -> str:
    """A number to some digits, with a power of ten where zeros would hide them."""
    return plain(value, digits) if abs(value) >= _SMALL else short(value, digits)


def _laws(legs: PredictedLegs) -> tuple[Law, ...]:
    def row(name: str, outcome: LegsOutcome) -> Law:
        return Law(name, _lengths(outcome.vibration), _lengths(outcome.resting_error))

    return tuple(row(name, outcome) for name, outcome in exported_sides(legs))


def _lengths(values: Sequence[float] | np.ndarray) -> str:
    median, worst = 1e3 * float(np.median(values)), 1e3 * float(np.max(values))
    return f"{plain(median)} ({plain(worst)})"


def _words(tuning: TuningFindings | None, legs: PredictedLegs | None) -> str:
    if tuning is None:
        return "No gains, shapers or plans are made from a fit that has failed."
    if legs is None:
        return "Legs weren't simulated for this tuning: see the manoeuvres below."
    planned = "" if legs.planned is None else len(legs.planned.vibration)
    fewer = (
        f", planned ones over the first {planned}"
        if planned and planned < len(legs.before.vibration)
        else ""
    )
    return (
        "Median (worst) in millimetres, peak to peak after the arrival and from the target, "
        f"over {len(legs.before.vibration)} random legs in the workspace{fewer}, simulated "
        f"with {legs.robots} robots as they might be."
    )
