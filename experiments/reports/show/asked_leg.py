"""The leg that a page asks for."""

import dataclasses
import math
from collections.abc import Mapping
from urllib.parse import urlencode

from scdpr_jax.robot.parameters import Robot
from tuning.plan.planning import LEG_TIME, Wanted
from tuning.result.tuning import Tuning

CLEAR = 0.05
"""Room between the end-effector and the frame [m]: nearer the stiffness has no limit."""
SHORTEST, LONGEST = 0.8, 8.0
"""Times of a leg that can be chosen [s]."""


@dataclasses.dataclass(frozen=True)
class Slider:
    """A number that the page lets one choose."""

    name: str
    """Its name in the address."""
    label: str
    """What it is."""
    unit: str
    """Its unit."""
    low: float
    """Least value."""
    high: float
    """Largest value."""
    step: float
    """Between two values."""
    value: float
    """Where it stands at first."""


@dataclasses.dataclass(frozen=True)
class AskedLeg:
    """A leg at a setting."""

    wanted: Wanted
    """The leg."""
    setting: float
    """Nominal pretension [N]."""

    @property
    def address(self) -> str:
        """The same as an address asks for it."""
        (x, y), (to_x, to_y) = self.wanted.start, self.wanted.end
        numbers = {"x": x, "y": y, "to_x": to_x, "to_y": to_y, "time": self.wanted.time}
        return urlencode({name: f"{number:g}" for name, number in numbers.items()}) + (
            f"&setting={self.setting:g}"
        )


def sliders(robot: Robot) -> tuple[Slider, ...]:
    """What can be chosen of a leg.

    Args:
        robot: The robot.

    Returns:
        Start, end and time.
    """
    width, height = float(robot.frame.width), float(robot.frame.height)
    lowest, highest = map(float, robot.heights)
    low = math.ceil(100 * (lowest + CLEAR)) / 100
    high = math.floor(100 * (highest - CLEAR)) / 100
    left, right = 0.2, math.floor(100 * (width - 0.2)) / 100
    middle = round(height / 2, 2)
    return (
        Slider("x", "from x", "m", left, right, 0.01, 0.3),
        Slider("y", "from y", "m", low, high, 0.01, middle),
        Slider("to_x", "to x", "m", left, right, 0.01, round(0.85 * width, 2)),
        Slider("to_y", "to y", "m", low, high, 0.01, middle),
        Slider("time", "time", "s", SHORTEST, LONGEST, 0.1, LEG_TIME),
    )


def asked_leg(query: Mapping[str, str], tuning: Tuning) -> AskedLeg:
    """The leg that an address asks for.

    Args:
        query: What stands in the address; what is missing is as the sliders stand at first.
        tuning: The tuning, which has a fitted robot.

    Returns:
        The leg.

    Raises:
        ValueError: If a number is none, or isn't between the slider's ends.
    """
    setting = _number("setting", query.get("setting", f"{tuning.robots[0].pretension:g}"))
    chosen = {}
    for slider in sliders(tuning.robot_at(setting).robot):
        number = _number(slider.label, query.get(slider.name, f"{slider.value:g}"))
        if not slider.low - 1e-9 <= number <= slider.high + 1e-9:
            raise ValueError(
                f"`{slider.label}` is outside of what can be chosen, got {number:g} "
                f"{slider.unit}, expected {slider.low:g} to {slider.high:g} {slider.unit}. "
                "Move the slider."
            )
        chosen[slider.name] = number
    start, end = (chosen["x"], chosen["y"]), (chosen["to_x"], chosen["to_y"])
    if start == end:
        raise ValueError("Start and end are the same place: there is no leg. Move a slider.")
    return AskedLeg(Wanted(start, end, chosen["time"]), setting)


def _number(name: str, text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"`{name}`: got {text[:20]!r}, expected a number. Move the slider.")
    return number
