"""A fitted robot's co-design, what stands beside it, and what it does where it hasn't been."""

import dataclasses
import re
from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from experiments.files.parameters_file import FittedRobot
from experiments.runtime import stage
from experiments.studies.posterior import draw
from tuning.codesign import (
    Designed,
    Models,
    evaluate,
    front,
    knee,
    models,
    references,
    usual_move_times,
)
from tuning.loop.admissible import PEAK_SENSITIVITY, PHASE_MARGIN, admissible
from tuning.loop.worst_margins import WorstMargin, margin_map, worst_margins
from tuning.result.types import FittedSetting

FRONT_POINTS = 4
"""Move times of a front that isn't asked for otherwise."""
_BEGIN = 0.3 / 2.224
"""Where legs begin, as a share of the frame's width [1]: as Table 3's horizontal manoeuvre."""
_ENDS = (0.7 / 2.224, 1.9 / 2.224)
"""Between which shares of it they end [1]."""
_CLEAR = 0.06
"""Distance that the end-effector keeps from the guides [m]."""


@dataclasses.dataclass(frozen=True)
class Asked:
    """What a co-design is to be for."""

    grid: tuple[int, int]
    """Columns and rows of the poses that legs end at."""
    samples: int
    """Robots drawn from the fit."""
    settings: tuple[float, ...]
    """Nominal pretensions [N]."""
    move_times: tuple[float, ...]
    """Times of a move [s]; none for the usual ones."""
    seed: int
    """Of the samples."""


@dataclasses.dataclass(frozen=True, eq=False)
class CoDesign:
    """A front of designs, the one that is recommended, and what stands beside it."""

    asked: Asked
    """What it is for."""
    chosen: Designed
    """The recommended design."""
    front: tuple[Designed, ...]
    """The front, the shortest move first."""
    compared: dict[str, tuple[Designed, ...]]
    """The references by name, in the front's times."""
    held_out: dict[str, Designed]
    """References and the recommended design on robots and poses in between."""
    margins: tuple[WorstMargin, ...]
    """Worst margins of the flexible robot's loops with the recommended gains."""
    margins_before: tuple[WorstMargin, ...]
    """The same with the gains of Eq. (25)."""
    robots: tuple[FittedSetting, ...]
    """The fitted robot at each setting."""
    voltage_limit: float
    """Largest command of the drives [V]."""

    @property
    def holds(self) -> bool:
        """Whether margins and voltage are kept, also where the design hasn't looked."""
        worst = {one.measure: one.value for one in self.margins}
        return (
            worst.get("phase_margin", 0.0) >= PHASE_MARGIN
            and worst["peak_sensitivity"] <= PEAK_SENSITIVITY
            and self.chosen.keeps_voltage(self.voltage_limit)
            and self.held_out[DESIGNED].keeps_voltage(self.voltage_limit)
        )


DESIGNED = "co-design"
"""Name of the recommended design among what was held out."""


def parse_grid(text: str) -> tuple[int, int]:
    """A grid as it is written.

    Args:
        text: "4x5": columns and rows.

    Returns:
        Both.

    Raises:
        ValueError: If it is no such text, or has less than one column or two rows.
    """
    match = re.fullmatch(r"\s*(\d+)\s*[x×]\s*(\d+)\s*", text)
    if match is None or int(match[1]) < 1 or int(match[2]) < 2:
        raise ValueError(
            f"`--grid`: got {text!r}, expected columns and rows of the poses that legs end at "
            '[1], such as "4x5", with two rows at the least.'
        )
    return int(match[1]), int(match[2])


def design(
    fitted: FittedRobot,
    asked: Asked,
    *,
    progress: Callable[[str, float], None] = lambda doing, share: None,
) -> CoDesign:
    """A co-design of a fitted robot.

    Args:
        fitted: The robot.
        asked: What it is to be for.
        progress: Told what is being done and which share of it is done.

    Returns:
        The co-design.

    Raises:
        ValueError: If nothing is asked for, or the move times are too short.
    """
    if asked.samples < 1:
        raise ValueError(
            f"`--samples`: got {asked.samples}, expected one robot or more [1]. 16 show what "
            "a fit leaves open."
        )
    ends, heights = _poses(fitted, asked.grid)
    begin = _BEGIN * float(fitted.robot.frame.width)
    drawn = draw(fitted, asked.settings, count=asked.samples, seed=asked.seed)
    seen = models(drawn, begin=begin, ends=ends, heights=heights)
    times = asked.move_times or usual_move_times(seen, count=FRONT_POINTS)
    robots = _fitted(fitted, asked.settings)
    progress("gains that keep their margins", 0.0)
    within = admissible([one.robot for one in robots])
    designs = front(seen, within, move_times=times, progress=stage(progress, 0.03, 0.8))
    chosen = knee(designs)
    unseen = _held_out(fitted, asked, begin, ends, heights)
    longest = max(times)

    progress("what it is compared with", 0.8)
    compared: dict[str, list[Designed]] = {}
    for number, one in enumerate(designs):
        for name, law in references(seen, move_time=one.move_time).items():
            compared.setdefault(name, []).append(evaluate(seen, law, longest=longest))
        progress("what it is compared with", 0.8 + 0.1 * (number + 1) / len(designs))
    laws = references(seen, move_time=chosen.move_time) | {DESIGNED: chosen.law}
    held_out = {name: evaluate(unseen, law, longest=longest) for name, law in laws.items()}
    progress("margins over the workspace", 0.95)
    before = laws["Eq. (25)"].controller
    return CoDesign(
        asked=dataclasses.replace(asked, move_times=tuple(times)),
        chosen=chosen,
        front=designs,
        compared={name: tuple(each) for name, each in compared.items()},
        held_out=held_out,
        margins=worst_margins(margin_map(robots, chosen.law.controller)),
        margins_before=worst_margins(margin_map(robots, before)),
        robots=robots,
        voltage_limit=float(fitted.robot.drive.voltage_limit),
    )


def _fitted(fitted: FittedRobot, settings: tuple[float, ...]) -> tuple[FittedSetting, ...]:
    """The fitted robot itself at every setting: a sample without errors."""
    certain = fitted.model_copy(
        update={
            "parameters": [row.model_copy(update={"sigma": 0.0}) for row in fitted.parameters]
        }
    )
    robots = draw(certain, settings, count=1, seed=0)
    return tuple(FittedSetting(s, robot) for s, robot in zip(settings, robots, strict=True))


def _poses(
    fitted: FittedRobot, grid: tuple[int, int]
) -> tuple[Float[np.ndarray, " columns"], Float[np.ndarray, " rows"]]:
    frame, body = fitted.robot.frame, fitted.robot.end_effector
    columns, rows = grid
    low = float(body.lower_offset) + _CLEAR
    high = float(frame.height - body.upper_offset) - _CLEAR
    first, last = (share * float(frame.width) for share in _ENDS)
    ends = np.linspace(first, last, columns) if columns > 1 else np.asarray([last])
    return ends, np.linspace(low, high, rows)


def _held_out(
    fitted: FittedRobot,
    asked: Asked,
    begin: float,
    ends: Float[np.ndarray, " columns"],
    heights: Float[np.ndarray, " rows"],
) -> Models:
    """Other samples, and poses midway between the grid's."""
    between = (ends[:-1] + ends[1:]) / 2 if ends.size > 1 else (begin + ends) / 2
    drawn = draw(
        fitted, asked.settings, count=max(asked.samples // 2, 1), seed=asked.seed + 1000
    )
    middles = (heights[:-1] + heights[1:]) / 2
    return models(drawn, begin=begin, ends=between, heights=middles)
