"""What a sweep can compute of a point: its inputs, its outputs, its function."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from experiments.sweep.axes import Axis, Variable
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import QUANTITIES, value

Values = Mapping[str, Float[Array, ""]]
"""Values of a measure's own variables at a point, by name."""
Compute = Callable[[Robot, Values], tuple[Array, ...]]
"""A point's outputs, in their order."""


class Output(NamedTuple):
    """One variable of a sweep's dataset."""

    name: str
    """Its name."""
    unit: str
    """SI unit, "1" for none."""
    meaning: str
    """What it is."""
    dimensions: tuple[str, ...] = ()
    """Dimensions beyond the sweep's axes."""


class Measure(NamedTuple):
    """What is computed of every point, and what it can be swept over."""

    name: str
    """Its name on the command line."""
    variables: tuple[Variable, ...]
    """What it takes beside the robot's quantities."""
    outputs: tuple[Output, ...]
    """What it computes."""
    labels: dict[str, tuple[str | int, ...]]
    """Labels of the outputs' own dimensions."""
    compute: Callable[[tuple[Axis, ...]], Compute]
    """From a sweep's axes to what computes a point; equal ones compile once."""
    chunk: int
    """Points that a device computes at a time."""
    unit: int
    """Points that are computed, kept and lost together: some tenths of a second's work."""
    most: int
    """The same of a sweep of millions, at the most: a unit's way costs some milliseconds."""

    def of_size(self, count: int) -> "Measure":
        """The measure with units that suit a sweep's size.

        Args:
            count: The sweep's points.

        Returns:
            It, with longer units where there are more than some hundreds.
        """
        times = min(max(count // (_UNITS * self.unit), 1), max(self.most // self.unit, 1))
        return self._replace(unit=times * self.unit)

    @property
    def known(self) -> tuple[Variable, ...]:
        """Everything that it can be swept over."""
        return (*self.variables, *ROBOT_VARIABLES)


_UNITS = 256
"""Units that a sweep is divided into before they become longer."""

ROBOT_VARIABLES: tuple[Variable, ...] = tuple(
    Variable(
        q.name, q.unit, q.meaning, lambda robot, name=q.name: value(robot, name), q.positive
    )
    for q in QUANTITIES
)
"""The robot's quantities, which every measure can be swept over."""

X = Variable(
    "x", "m", "position of the end-effector along the frame", lambda r: r.frame.width / 2, None
)
"""The end-effector's position along the frame, by default in the middle."""
Y = Variable("y", "m", "height of the end-effector", lambda r: r.frame.height / 2, None)
"""The end-effector's height, by default in the middle."""


def only_if(valid: Array, output: Float[Array, "..."]) -> Float[Array, "..."]:
    """An output where it means something.

    Args:
        valid: Whether it does.
        output: The output.

    Returns:
        The output, or not a number.
    """
    return jnp.where(valid, output, jnp.nan)
