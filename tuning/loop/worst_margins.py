"""The least margins of the flexible robot's loops over its workspace, and where they are."""

import dataclasses
from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import jax
import numpy as np
from jaxtyping import Float

from scdpr_jax.command.controller import PD
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from tuning.loop.flexible_loop import JOINT_LOOPS
from tuning.loop.flexible_margins import FlexibleMargins, flexible_margins

_HEIGHTS = 21
"""Heights that are looked at; margins are smooth in it but where another crossing is least."""
_CLEAR = 0.05
"""Distance of the end-effector from the guides [m]: nearer its cables have no length."""
_JUDGED = (
    # A loop whose gain never reaches one has no such margin, which is none to worry about.
    ("phase_margin", lambda margins: np.argmin(np.nan_to_num(margins, nan=np.inf))),
    ("delay_margin", lambda margins: np.argmin(np.nan_to_num(margins, nan=np.inf))),
    ("gain_margin", lambda margins: np.argmin(np.abs(np.log(margins)))),
    ("peak_sensitivity", np.argmax),
)
"""Measures by their field's name, with where the worst one is."""


@runtime_checkable
class Fitted(Protocol):
    """A robot at a nominal setting of its pretension [N]."""

    @property
    def pretension(self) -> float: ...
    @property
    def robot(self) -> Robot: ...


@dataclasses.dataclass(frozen=True)
class WorstMargin:
    """The worst value of one measure of stability, and where it is."""

    measure: str
    """The field of `Margins`; "spectral_radius" where a loop is unstable."""
    value: float
    """Its value [SI unit of the field]."""
    loop: str
    """Which loop has it, a name of `JOINT_LOOPS`."""
    height: float = dataclasses.field(metadata=si("m", "y_e"))
    """At which height of the end-effector [m]."""
    pretension: float = dataclasses.field(metadata=si("N", "T"))
    """At which nominal setting [N]."""


@dataclasses.dataclass(frozen=True, eq=False)
class MarginMap:
    """Margins over the workspace."""

    pretension: Float[np.ndarray, " settings"]
    """Nominal settings [N]."""
    height: Float[np.ndarray, " heights"]
    """Heights of the end-effector [m]."""
    flexible: FlexibleMargins
    """Margins by loop, setting and height."""


def reach(robot: Robot) -> tuple[float, float]:
    """The lowest and the highest place that margins are looked at.

    Args:
        robot: The robot.

    Returns:
        Both heights of the end-effector [m].
    """
    low, high = map(float, robot.heights)
    return low + _CLEAR, high - _CLEAR


def margin_map(robots: Sequence[Fitted], controller: PD) -> MarginMap:
    """Margins of every joint loop over the heights within reach, at every setting.

    Args:
        robots: The robot at each of its settings, one at least.
        controller: The controller of both drives.

    Returns:
        The map.
    """
    stacked = jax.tree.map(
        lambda *leaves: np.stack(leaves), *(fitted.robot for fitted in robots)
    )
    height = np.linspace(*reach(robots[0].robot), _HEIGHTS)
    flexible = flexible_margins(stacked, height, controller)
    return MarginMap(np.asarray([fitted.pretension for fitted in robots]), height, flexible)


def worst_margins(margins: MarginMap) -> tuple[WorstMargin, ...]:
    """The worst margins of a map.

    Args:
        margins: The map.

    Returns:
        The least phase, delay and gain margin and the largest peak sensitivity; of a
        map with an unstable loop the largest spectral radius alone.
    """
    radius = np.asarray(margins.flexible.spectral_radius)
    if not np.all(radius < 1):
        return (_at(margins, "spectral_radius", radius, int(np.argmax(radius))),)
    worst = []
    for name, choose in _JUDGED:
        values = np.asarray(getattr(margins.flexible.margins, name))
        worst.append(_at(margins, name, values, int(choose(values))))
    return tuple(worst)


def _at(
    margins: MarginMap,
    name: str,
    values: Float[np.ndarray, "loops settings heights"],
    index: int,
) -> WorstMargin:
    loop, setting, height = np.unravel_index(index, values.shape)
    return WorstMargin(
        measure=name,
        value=float(values[loop, setting, height]),
        loop=JOINT_LOOPS[loop].name,
        height=float(margins.height[height]),
        pretension=float(margins.pretension[setting]),
    )
