"""Cells of the workspace: where one natural frequency is taken to hold."""

import dataclasses
import itertools
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from scdpr_jax.linear.modes import BOTH_HELD, held_frequency, natural_frequencies
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import replace, value
from tuning.result.regional_shaper import Range, Region

SAME_PLACE = 0.1
"""Knocks nearer than this are at one place of the grid [m]."""


@runtime_checkable
class Frequencies(Protocol):
    """A map of measured natural frequencies, one row a knock."""

    x: Float[np.ndarray, " knocks"]
    y: Float[np.ndarray, " knocks"]
    pretension: Float[np.ndarray, " knocks"]
    frequency: Float[np.ndarray, " knocks"]
    frequency_sigma: Float[np.ndarray, " knocks"]
    damping_ratio: Float[np.ndarray, " knocks"]


@dataclasses.dataclass(frozen=True)
class Cell:
    """A region with its natural frequency while friction holds both carriages."""

    region: Region
    """Where it holds."""
    height: float = dataclasses.field(metadata=si("m", "y_e"))
    """Height that stands for it [m]."""
    frequency: float = dataclasses.field(metadata=si("Hz", "f_n"))
    """Natural frequency [Hz]."""
    sigma: float = dataclasses.field(metadata=si("Hz"))
    """Its standard error [Hz]; 0 for the model's."""
    damping_ratio: float = dataclasses.field(metadata=si("1", r"\zeta"))
    """Damping ratio [1]."""
    measured: bool
    """Whether a knock was measured in it."""

    @property
    def band(self) -> Range:
        """The frequency less and plus two standard errors [Hz]."""
        return self.frequency - 2 * self.sigma, self.frequency + 2 * self.sigma


def cells_of(frequencies: Frequencies, robot: Robot, *, pretension: float) -> tuple[Cell, ...]:
    """The grid of cells at one pretension setting, which covers the frame.

    Distinct places of the knocks make the grid; its lines lie midway between them. Knocks
    in one cell that ring in its first mode are averaged with the inverse squares of their
    standard errors, a cell without any has the model's frequency.

    Args:
        frequencies: The measured map.
        robot: The robot at that setting.
        pretension: The nominal setting [N].

    Returns:
        The cells, from the lower left corner row by row.
    """
    here = np.flatnonzero(frequencies.pretension == pretension)
    swaying = np.setdiff1d(here, other_modes(frequencies, robot, pretension=pretension))
    width, height = float(robot.frame.width), float(robot.frame.height)
    columns = _places(frequencies.x[here], width)
    rows = _places(frequencies.y[here], height)
    settings = (pretension, pretension)
    cells = []
    for middle, y in rows:
        for _, x in columns:
            region = Region(x=x, y=y, pretension=settings)
            inside = [
                k
                for k in swaying
                if region.contains(float(frequencies.x[k]), float(frequencies.y[k]), pretension)
            ]
            cells.append(_cell(region, middle, frequencies, inside, robot))
    return tuple(cells)


def other_modes(
    frequencies: Frequencies, robot: Robot, *, pretension: float
) -> tuple[int, ...]:
    """Knocks at one pretension setting that ring in another mode than the first.

    Friction may end the end-effector's sway and leave its rotation.

    Args:
        frequencies: The measured map.
        robot: The robot at that setting.
        pretension: The nominal setting [N].

    Returns:
        Rows of those whose frequency is nearer to another of the model's, as a ratio.
    """
    rows = np.flatnonzero(frequencies.pretension == pretension)
    heights = np.asarray(frequencies.y[rows], dtype=float)
    modes = [np.asarray(natural_frequencies(robot, np.asarray(y), BOTH_HELD)) for y in heights]
    return tuple(
        int(row)
        for row, frequency in zip(rows, modes, strict=True)
        if np.argmin(np.abs(np.log(frequency / frequencies.frequency[row]))) != 0
    )


def robot_in(cell: Cell, robot: Robot) -> Robot:
    r"""The robot whose held frequency at the cell's height is the cell's.

    $f \propto \sqrt{T}$ gives the effective pretension; the coefficients of friction make up
    for it, as the friction force $4T\mu$ is what logs determine.

    Args:
        cell: The cell.
        robot: The robot at the cell's setting.

    Returns:
        The robot in the cell.
    """
    share = (cell.frequency / _held_frequency(robot, cell.height)) ** 2
    scale = {
        "effective_pretension": share,
        "friction_coefficient": 1 / share,
        "upper_friction_coefficient": 1 / share,
    }
    return replace(robot, {name: by * float(value(robot, name)) for name, by in scale.items()})


def _cell(
    region: Region,
    middle: float,
    frequencies: Frequencies,
    inside: list[np.intp],
    robot: Robot,
) -> Cell:
    if not inside:
        return Cell(region, middle, _held_frequency(robot, middle), 0.0, 0.0, False)
    sigma = frequencies.frequency_sigma[inside]
    # A standard error of 0 in a hand-written map would leave the others no weight.
    weights = 1 / np.square(np.maximum(sigma, 1e-6 * frequencies.frequency[inside]))
    weights /= weights.sum()
    mean = float(weights @ frequencies.frequency[inside])
    scatter = float(np.sqrt(weights @ np.square(frequencies.frequency[inside] - mean)))
    error = float(np.sqrt(np.square(weights) @ np.square(sigma)))
    return Cell(
        region,
        float(weights @ frequencies.y[inside]),
        mean,
        max(error, scatter),
        float(weights @ frequencies.damping_ratio[inside]),
        True,
    )


def _held_frequency(robot: Robot, height: float) -> float:
    return float(held_frequency(robot, np.asarray(height)))


def _places(
    positions: Float[np.ndarray, " knocks"], length: float
) -> list[tuple[float, Range]]:
    """Distinct places along one axis, each with its stretch of the frame [m]."""
    if len(positions) == 0:
        return [(length / 2, (0.0, length))]
    ordered = np.sort(positions)
    groups = np.split(ordered, np.flatnonzero(np.diff(ordered) > SAME_PLACE) + 1)
    middles = [float(group.mean()) for group in groups]
    lines = [(low + high) / 2 for low, high in itertools.pairwise(middles)]
    edges = [0.0, *lines, length]
    return list(zip(middles, itertools.pairwise(edges), strict=True))
