"""`scdpr_leg.h` and `scdpr_leg.c`: the planner of one robot in C99."""

import dataclasses
from collections.abc import Iterable

import jax
import numpy as np
from jaxtyping import Float

from scdpr_jax.command.controller import PD
from scdpr_jax.legs.starts import steepest_held_slope
from scdpr_jax.robot.parameters import Robot
from tuning.export.description import decimal
from tuning.export.onboard.kernels import kernels_text
from tuning.export.template import fill_in
from tuning.plan import leg, pace, planning
from tuning.plan.expectation import AFTERWARDS, ROBOTS, pd_numbers
from tuning.plan.led.servo import servo
from tuning.plan.search import grid, misfit, stages
from tuning.plan.search.scenarios import FARTHEST, VARIATIONS, scenarios

HEADER, SOURCE = "scdpr_leg.h", "scdpr_leg.c"
"""Names of the files."""
_MOST_TIME = 12.0
"""Longest leg, where the table of its commands isn't too long [s]."""
_MOST_SAMPLES = 40_000
"""Rows of that table: three of them are half of the 2 MB that a leg may take."""


@dataclasses.dataclass(frozen=True, eq=False)
class OnBoard:
    """The robot that plans, and its controller."""

    robot: Robot
    """The fitted robot."""
    controller: PD
    """Its controller."""
    about: str = ""
    """What is to be said in the header."""

    @property
    def most_time(self) -> float:
        """Time of the longest leg [s]."""
        return min(_MOST_TIME, _MOST_SAMPLES * float(self.controller.period))

    @property
    def sizes(self) -> dict[str, int]:
        """Sizes of tables."""
        period = float(self.controller.period)
        coarse = int(np.ceil(self.most_time / stages.COARSE))
        return {
            "splines": leg.MOST_SPLINES,
            "robots": 1 + len(VARIATIONS),
            "judged": len(ROBOTS),
            "steps": round(stages.COARSE / stages.FINE) * coarse,
            "samples": int(np.ceil(self.most_time / period)),
        }

    def header(self) -> str:
        """Text of `scdpr_leg.h`."""
        sizes = self.sizes
        # Doubles of the longest tables: three motions, half steps and whole ones.
        doubles = 6 * sizes["samples"] + 16 * sizes["steps"] + 15 * sizes["steps"]
        return fill_in(
            f"onboard/{HEADER}",
            about=f" {self.about}" if self.about else "",
            kilobytes=str(-(-8 * doubles // 1000) + 100),
            period=decimal(self.controller.period),
            most_time=decimal(self.most_time),
            **{name: str(size) for name, size in sizes.items()},
        )

    def source(self) -> str:
        """Text of `scdpr_leg.c`."""
        numbers = jax.tree.leaves(self.robot)
        return fill_in(
            f"onboard/{SOURCE}",
            kernels=kernels_text(self.robot),
            numbers=str(len(numbers)),
            tables="\n".join(self._tables()),
            **_constants(self.robot),
        )

    def _tables(self) -> Iterable[str]:
        robot, controller = self.robot, self.controller
        about = stages.models(robot, controller, told=False)
        others, told = (scenarios(robot, VARIATIONS, told=own) for own in (False, True))
        lowest, highest = robot.heights
        single = {
            "RADIUS": robot.drive.effective_radius,
            "FRAME_HEIGHT": robot.frame.height,
            "FRAME_WIDTH": robot.frame.width,
            "LOWEST": lowest,
            "HIGHEST": highest,
            "STEEPEST": 2 * steepest_held_slope(robot) + planning.UNSTEADY,
        }
        for name, number in single.items():
            yield f"static const double {name} = {_number(number)};"
        yield _array("FITTED", "[NUMBERS]", _rows(about.fitted.robots.robot)[0])
        guesses = np.concatenate([_rows(own.robots.robot) for own in about.guesses])
        yield _array("GUESSES", f"[{len(guesses)}][NUMBERS]", guesses)
        yield _array("OTHERS", "[SCDPR_LEG_ROBOTS - 1][NUMBERS]", _rows(others.robot))
        slopes = np.array([[0.0, *own.slope] for own in (others, told)])
        yield _array("SLOPE", "[2][SCDPR_LEG_ROBOTS]", slopes)
        yield _array("WEIGHT", "[SCDPR_LEG_ROBOTS]", np.array([1.0, *others.weight]))
        yield _array("RESTS", "[SCDPR_LEG_ROBOTS]", np.array([1.0, *others.resting]))
        yield _array("SERVO", "[3]", np.array(servo(robot, controller)))
        gains = np.array([float(own) for own in pd_numbers(controller)])
        yield _array("CONTROLLER", "[4]", gains)


def _constants(robot: Robot) -> dict[str, str]:
    """The search's own numbers, as its template has them."""
    limit = float(robot.drive.voltage_limit)
    half = float(robot.lower_carriage.width) / 2
    extremes = 3 * (stages.EXTREME,)
    in_order = (stages.FIRST, stages.GUESS, stages.GUESS, *extremes, stages.ALL, stages.LAST)
    numbers = {
        "rest": leg.REST,
        "spline_width": leg.SPLINE_WIDTH,
        "vibration": misfit.VIBRATION,
        "resting": misfit.RESTING,
        "sliding": misfit.SLIDING,
        "tracking": misfit.TRACKING,
        "allowed_volts": misfit.VOLTAGE_SHARE * limit,
        "voltage": misfit.VOLTAGE,
        "roughness": misfit.ROUGHNESS,
        "outside": misfit.OUTSIDE,
        "guide_low": half,
        "guide_high": float(robot.frame.width) - half,
        "coarse": stages.COARSE,
        "longer": planning.LONGER,
        "stretch": pace.STRETCH,
        "still": planning.STILL,
        "on_target": planning.ON_TARGET,
        "within_volts": planning.WITHIN * limit,
        "plain_volts": pace.PLAIN_SHARE * limit,
        "shortest": pace.SHORTEST,
        "negligible": planning.NEGLIGIBLE,
        "afterwards": AFTERWARDS,
        "fall": stages.DAMPING.fall,
        "rise": stages.DAMPING.rise,
        "floor": stages.DAMPING.floor,
        "first_damping": stages.DAMPING.first,
        "least": stages.DAMPING.least,
        "just_before": grid.JUST_BEFORE,
        "unforetold": planning.UNFORETOLD,
    }
    whole = {
        "attempts": planning.ATTEMPTS,
        "rejections": stages.REJECTIONS,
        "instants": pace.INSTANTS,
        "tracked": grid.TRACKED,
        "commanded": grid.COMMANDED,
        "fewest_splines": leg.FEWEST_SPLINES,
        "farthest": len(FARTHEST),
    }
    return {
        **{name: _number(number) for name, number in numbers.items()},
        **{name: str(number) for name, number in whole.items()},
        "orders": ", ".join(map(_number, pace.ORDERS)),
        "stages": ", ".join(f"{{{own.steps}, {_number(own.saving)}}}" for own in in_order),
    }


def _rows(robots: Robot) -> Float[np.ndarray, "robots numbers"]:
    return np.stack([np.asarray(leaf, float) for leaf in jax.tree.leaves(robots)], axis=1)


def _number(number: object) -> str:
    return repr(float(number))


def _array(name: str, sizes: str, numbers: np.ndarray) -> str:
    def text(own: object) -> str:
        return "{" + ", ".join(map(text, own)) + "}" if np.ndim(own) else _number(own)

    rows = [text(own) for own in numbers] if numbers.ndim > 1 else [text(numbers)[1:-1]]
    body = ",\n    ".join(rows)
    return f"static const double {name}{sizes} = {{\n    {body}}};"
