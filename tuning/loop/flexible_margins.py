r"""Margins of the flexible robot's joint loops over its workspace, as the controller samples.

The horizontal position doesn't matter, so that the workspace is heights by pretensions.
"""

import dataclasses
from collections.abc import Callable

import jax
import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from scdpr_jax.command.controller import PD
from scdpr_jax.robot.drive import drive_gain, drive_pole
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from tuning.loop.flexible_loop import (
    JOINT_LOOPS,
    Plants,
    PlantsOfPoles,
    closed_loop_matrices,
    controller_response,
    plants,
)
from tuning.loop.margins import DECADES, HALVINGS, SECTIONS, Margins, crossover_scale

_EVEN_POINTS = 256
"""Grid points that lie evenly over the logarithm of the frequency."""
_NEAR = np.array([10 ** -(power / 2) for power in range(1, 14)])
"""Relative distances of grid points from a resonance: damping ratios down to 1e-6 show."""


@dataclasses.dataclass(frozen=True, eq=False)
class FlexibleMargins:
    """How far joint loops of flexible robots are from instability."""

    margins: Margins
    r"""The least margins over all crossings; not numbers in an unstable loop. The phase
    margin is the angle to $-1$ in either direction, the delay margin the least of all
    crossings' lag over frequency."""
    spectral_radius: Float[np.ndarray, "*controllers loops robots heights"] = dataclasses.field(
        metadata=si("1", r"\rho")
    )
    r"""Largest modulus of the closed loop's poles $\rho$ [1]; the loop is stable below 1."""


def flexible_margins(
    robots: Robot,
    heights: Float[np.ndarray, " heights"],
    controllers: PD,
    *,
    delay: int = 1,
) -> FlexibleMargins:
    r"""Margins of every joint loop at aligned poses: hold, PD and computing time as they run.

    Poles of the closed loop decide whether it is stable. The frequencies are searched between
    the grid's points, which crowd around every resonance of the plant and every pole of the
    closed loop.

    Args:
        robots: Robots, stacked leaf by leaf, such as one for each pretension; of their
            friction laws only the viscous part counts.
        heights: Heights $y_e$ of the end-effector [m].
        controllers: The controller of both drives, or several of one period, stacked.
        delay: Samples from a measurement to its command.

    Returns:
        Margins by loop (those of `JOINT_LOOPS`), robot and height, behind an axis of
        controllers if they are stacked.

    Raises:
        ValueError: If the delay is negative, or periods differ.
    """
    if delay < 0:
        raise ValueError(
            f"`delay` must not be negative [samples], got {delay}: a command that is out "
            "before the next sample has 0, one that waits for it has 1."
        )
    several = np.shape(controllers.period)
    each = jax.tree.map(lambda leaf: np.atleast_1d(np.asarray(leaf, float)), controllers)
    periods = np.unique(each.period)
    if periods.size != 1:
        raise ValueError(
            f"`controllers` must have one period [s], got {periods.tolist()}: a plant behind a "
            "hold is another at another period."
        )
    robots = jax.tree.map(lambda leaf: np.asarray(leaf, float), robots)
    heights = np.asarray(heights, float)
    own, resonances = plants(robots, heights, period=float(periods[0]))
    loops = _Loops.of(own, each, delay)
    matrices = closed_loop_matrices(loops.plants, loops.controllers, delay=delay)
    poles = np.linalg.eigvals(matrices)
    radius = np.max(np.abs(poles), axis=-1)
    shape = *several, len(JOINT_LOOPS), len(robots.frame.height), len(heights)
    scale = np.zeros((each.period.size, *shape[-3:]))
    side_by_side = jax.tree.map(lambda leaf: leaf[:, None], each)
    bare = crossover_scale(drive_gain(robots.drive), drive_pole(robots.drive), side_by_side)
    scale += bare[:, None, :, None]
    special = np.concatenate(
        [
            np.tile(resonances, (each.period.size, 1)),
            np.abs(np.angle(poles)) / loops.controllers.period[:, None],
        ],
        axis=1,
    )
    made = _least_margins(loops, _grid(scale.ravel(), float(periods[0]), special))
    margins = [np.where(radius < 1, leaf, np.nan).reshape(shape) for leaf in made]
    return FlexibleMargins(Margins(*margins), radius.reshape(shape))


@dataclasses.dataclass(frozen=True, eq=False)
class _Loops:
    r"""Open loops, a row each, $L = z^{-d} R(z)\, c\, ((z - 1) I - \Delta)^{-1} \Gamma$."""

    plants: Plants
    poles: PlantsOfPoles
    controllers: PD
    delay: int

    @classmethod
    def of(cls, own: Plants, controllers: PD, delay: int) -> "_Loops":
        """Every plant under each controller."""
        number, plant = np.divmod(
            np.arange(len(own.input) * controllers.period.size), len(own.input)
        )
        each = jax.tree.map(lambda leaf: leaf[number], controllers)
        all_plants = Plants(own.difference[plant], own.input[plant], own.output[plant])
        gain = each.proportional_gain + each.derivative_gain / each.period
        return cls(all_plants, PlantsOfPoles.of(all_plants, gain), each, delay)

    def __call__(
        self,
        row: Int[np.ndarray, "*#n"],
        angular_frequency: Float[np.ndarray, "*n"],
        *,
        exactly: bool = False,
    ) -> Complex[np.ndarray, "*n"]:
        """Responses of some loops, by poles or exactly."""
        step = np.expm1(1j * angular_frequency * self.controllers.period[row])
        plant = (self.plants if exactly else self.poles).response(row, step)
        return plant * controller_response(
            self.controllers, row, angular_frequency, delay=self.delay
        )


def _grid(
    scale: Float[np.ndarray, " loops"], period: float, special: Float[np.ndarray, "loops k"]
) -> Float[np.ndarray, "loops points"]:
    nyquist = np.pi / period
    lowest = 10**-DECADES * np.minimum(scale, nyquist)[:, None]
    even = lowest * (nyquist / lowest) ** np.linspace(0.0, 1.0, _EVEN_POINTS)
    near = np.concatenate([1 / (1 + _NEAR), 1 + _NEAR])
    around = (special[:, :, None] * near).reshape(len(special), -1)
    return np.sort(np.concatenate([even, np.clip(around, lowest, nyquist)], axis=1), axis=1)


def _least_margins(
    loops: _Loops, grid: Float[np.ndarray, "loops points"]
) -> tuple[Float[np.ndarray, " loops"], ...]:
    """The fields of `Margins`."""
    every, nyquist = np.arange(len(grid)), grid[:, -1]
    values = loops(every[:, None], grid)

    row, at = _crossings(loops, grid, _gain_crosses(values), _log_gain)
    lag = np.angle(-loops(row, at, exactly=True))
    narrowest = _least(np.abs(lag), row, len(grid))
    spare = np.mod(lag, 2 * np.pi) / at

    across, where = _crossings(loops, grid, _phase_crosses(values), _phase_over_half_turn)
    gain = 1 / np.abs(loops(across, where, exactly=True))
    nearest = _least(np.abs(np.log(gain)), across, len(grid))
    # Where no change of sign marks a real response: at the Nyquist frequency.
    last = loops(every, nyquist, exactly=True).real
    margin, at_last = _at(gain, nearest, none=np.inf), 1 / np.abs(last)
    nearer = (last < 0) & (np.abs(np.log(at_last)) < np.abs(np.log(margin)))
    return (
        _at(at, narrowest),
        _at(np.abs(lag), narrowest),
        _at(spare, _least(spare, row, len(grid))),
        np.where(nearer, nyquist, _at(where, nearest)),
        np.where(nearer, at_last, margin),
        _peak_sensitivity(loops, grid, values),
    )


def _gain_crosses(values: Complex[np.ndarray, "loops n"]) -> Bool[np.ndarray, "loops n-1"]:
    above = np.abs(values) > 1
    return above[:, :-1] != above[:, 1:]


def _phase_crosses(values: Complex[np.ndarray, "loops n"]) -> Bool[np.ndarray, "loops n-1"]:
    negative, above = values.real < 0, values.imag > 0
    return (above[:, :-1] != above[:, 1:]) & negative[:, :-1] & negative[:, 1:]


_Measure = Callable[[Complex[np.ndarray, "*n"]], Float[np.ndarray, "*n"]]


def _log_gain(value: Complex[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
    return np.log(np.abs(value))


def _phase_over_half_turn(value: Complex[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
    return np.angle(-value)


def _crossings(
    loops: _Loops,
    grid: Float[np.ndarray, "loops points"],
    marks: Bool[np.ndarray, "loops intervals"],
    measure: _Measure,
) -> tuple[Int[np.ndarray, " crossings"], Float[np.ndarray, " crossings"]]:
    """Which loops have a measure that vanishes, and at which angular frequencies [rad/s]."""
    row, column = np.nonzero(marks)
    low, high = grid[row, column], grid[row, column + 1]
    sign = np.sign(measure(loops(row, low)))
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        before = measure(loops(row, middle)) * sign > 0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    # What the poles' response rounds is made up for by a step of the plant's own.
    rise = measure(loops(row, high)) - measure(loops(row, low))
    flat = rise == 0
    slope = np.where(flat, 1.0, rise) / np.where(flat, 1.0, high - low)
    middle = (low + high) / 2
    off = measure(loops(row, middle, exactly=True))
    return row, middle - np.where(flat, 0.0, off / slope)


def _least(
    values: Float[np.ndarray, " n"], row: Int[np.ndarray, " n"], rows: int
) -> Int[np.ndarray, " rows"]:
    """Which of the values of each row is the least, -1 where a row has none."""
    order = np.lexsort((values, row))
    found, first = np.unique(row[order], return_index=True)
    least = np.full(rows, -1)
    least[found] = order[first]
    return least


def _at(
    values: Float[np.ndarray, " n"], index: Int[np.ndarray, " rows"], *, none: float = np.nan
) -> Float[np.ndarray, " rows"]:
    """Values that `_least` found."""
    return np.append(values, none)[index]


def _peak_sensitivity(
    loops: _Loops,
    grid: Float[np.ndarray, "loops points"],
    values: Complex[np.ndarray, "loops points"],
) -> Float[np.ndarray, " loops"]:
    """Largest $1 / |1 + L|$, by golden section around the grid's nearest point to $-1$."""
    every, golden = np.arange(len(grid)), (5.0**0.5 - 1) / 2

    def distance(at: Float[np.ndarray, " loops"]) -> Float[np.ndarray, " loops"]:
        return np.abs(1 + loops(every, at))

    nearest = np.argmin(np.abs(1 + values), axis=1)
    low = grid[every, np.maximum(nearest - 1, 0)]
    high = grid[every, np.minimum(nearest + 1, grid.shape[1] - 1)]
    left, right = high - golden * (high - low), low + golden * (high - low)
    at_left, at_right = distance(left), distance(right)
    for _ in range(SECTIONS):
        go_left = at_left < at_right
        low, high = np.where(go_left, low, left), np.where(go_left, right, high)
        inside, at_inside = np.where(go_left, left, right), np.where(go_left, at_left, at_right)
        new = np.where(go_left, high - golden * (high - low), low + golden * (high - low))
        at_new = distance(new)
        left, at_left = np.where(go_left, (new, at_new), (inside, at_inside))
        right, at_right = np.where(go_left, (inside, at_inside), (new, at_new))
    return 1 / np.abs(1 + loops(every, (low + high) / 2, exactly=True))
