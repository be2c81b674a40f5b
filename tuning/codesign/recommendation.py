"""The design to recommend, the front that it is of, and what stands beside it."""

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from scdpr_jax.numerics.progress import SILENT, Progress, listening
from scdpr_jax.robot.parameters import Robot
from tuning.codesign.designed import Designed, evaluate
from tuning.codesign.front import front, knee, usual_move_times
from tuning.codesign.models import Models, models
from tuning.codesign.search import Designer, in_turn
from tuning.codesign.shaped_legs import references
from tuning.loop.admissible import PEAK_SENSITIVITY, PHASE_MARGIN, admissible
from tuning.loop.worst_margins import WorstMargin, margin_map, worst_margins
from tuning.result.tuning import FittedSetting

DESIGNED = "co-design"
"""Name of the recommended design among what was held out."""
FRONT_POINTS = 4
"""Move times of a front that isn't asked for otherwise."""
_BEGIN = 0.3 / 2.224
"""Where legs begin, as a share of the frame's width [1]: as Table 3's horizontal manoeuvre."""
_ENDS = (0.7 / 2.224, 1.9 / 2.224)
"""Between which shares of it they end [1]."""
_CLEAR = 0.06
"""Distance that the end-effector keeps from the guides [m]."""


@dataclasses.dataclass(frozen=True)
class Scope:
    """What a co-design is for: poses, settings, move times, and robots as they might be."""

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


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class CoDesign:
    """A front of designs, the one that is recommended, and what stands beside it."""

    scope: Scope
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
        worst = {margin.measure: margin.value for margin in self.margins}
        return (
            worst.get("phase_margin", 0.0) >= PHASE_MARGIN
            and worst["peak_sensitivity"] <= PEAK_SENSITIVITY
            and self.chosen.keeps_voltage(self.voltage_limit)
            and self.held_out[DESIGNED].keeps_voltage(self.voltage_limit)
        )

    def __repr__(self) -> str:
        columns, rows = self.scope.grid
        settings = ", ".join(f"{setting:g} N" for setting in self.scope.settings)
        held_out = self.held_out[DESIGNED]
        return (
            f"CoDesign for {columns} x {rows} poses, {self.scope.samples} robots at "
            f"{settings}\n  {self.chosen!r}\n"
            f"  not seen: worst tenth {1e3 * held_out.vibration:.3g} mm; margins and voltage "
            f"{'kept' if self.holds else 'NOT kept'}"
        )


def recommend(
    robots: tuple[FittedSetting, ...],
    scope: Scope,
    *,
    drawn: Sequence[Robot],
    unseen: Sequence[Robot],
    designer: Designer = in_turn,
    progress: Progress | bool = SILENT,
) -> CoDesign:
    """A front of designs for robots as they might be, and the one to take.

    Args:
        robots: The fitted robot at each of the scope's settings.
        scope: What it is for.
        drawn: Robots as they might be, which the designs are made for.
        unseen: Others, which they are judged on besides, at poses in between.
        designer: Who descends from the starts of all move times: they are independent.
        progress: Told what is being done and which share of it is done;
            True shows it in a notebook.

    Returns:
        The co-design.

    Raises:
        ValueError: If the move times are too short.
    """
    progress = listening(progress)
    robot = robots[0].robot
    begin = _BEGIN * float(robot.frame.width)
    ends, heights = _poses(robot, scope.grid)
    seen = models(drawn, begin=begin, ends=ends, heights=heights)
    others = _between(unseen, begin, ends, heights)
    times = scope.move_times or usual_move_times(seen, count=FRONT_POINTS)
    progress("gains that keep their margins", 0.0)
    within = admissible([fitted.robot for fitted in robots])
    designs = front(
        seen,
        within,
        move_times=times,
        designer=designer,
        progress=progress.part(0.03, 0.8),
    )
    chosen, longest = knee(designs), max(times)
    progress("what it is compared with", 0.8)
    compared: dict[str, list[Designed]] = {}
    for number, design in enumerate(designs):
        for name, law in references(seen, move_time=design.move_time).items():
            compared.setdefault(name, []).append(evaluate(seen, law, longest=longest))
        progress("what it is compared with", 0.8 + 0.1 * (number + 1) / len(designs))
    laws = references(seen, move_time=chosen.move_time) | {DESIGNED: chosen.law}
    held_out = {name: evaluate(others, law, longest=longest) for name, law in laws.items()}
    progress("margins over the workspace", 0.95)
    before = laws["Eq. (25)"].controller
    return CoDesign(
        scope=dataclasses.replace(scope, move_times=tuple(times)),
        chosen=chosen,
        front=designs,
        compared={name: tuple(each) for name, each in compared.items()},
        held_out=held_out,
        margins=worst_margins(margin_map(robots, chosen.law.controller)),
        margins_before=worst_margins(margin_map(robots, before)),
        robots=robots,
        voltage_limit=float(robot.drive.voltage_limit),
    )


def _poses(
    robot: Robot, grid: tuple[int, int]
) -> tuple[Float[np.ndarray, " columns"], Float[np.ndarray, " rows"]]:
    columns, rows = grid
    low, high = map(float, robot.heights)
    first, last = (share * float(robot.frame.width) for share in _ENDS)
    ends = np.linspace(first, last, columns) if columns > 1 else np.asarray([last])
    return ends, np.linspace(low + _CLEAR, high - _CLEAR, rows)


def _between(
    unseen: Sequence[Robot],
    begin: float,
    ends: Float[np.ndarray, " columns"],
    heights: Float[np.ndarray, " rows"],
) -> Models:
    """Other robots at poses midway between the grid's."""
    between = (ends[:-1] + ends[1:]) / 2 if ends.size > 1 else (begin + ends) / 2
    middles = (heights[:-1] + heights[1:]) / 2
    return models(unseen, begin=begin, ends=between, heights=middles)
