"""What an engine is called with: shapes, signs and values that can't be are refused.

NumPy's broadcasting and slicing take nearly everything: of a table with its time first, the
first drive gets the time in volts; one column drives both; a time that goes backwards throws
the robot out of its frame. All of that runs and looks like a result. Shapes are known when a
program is traced, so they are always checked. Numbers are checked where they are known, and
a duration that can't be gives NaN where it is traced.
"""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.robot.fields import concrete, refuse
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import State

_ABOVE_ZERO = {
    "frame.height": lambda r: r.frame.height,
    "end_effector.mass": lambda r: r.end_effector.mass,
    "end_effector.inertia": lambda r: r.end_effector.inertia,
    "lower_carriage.mass": lambda r: r.lower_carriage.mass,
    "upper_carriage.mass": lambda r: r.upper_carriage.mass,
    "drive.inertia": lambda r: r.drive.inertia,
    "drive.effective_radius": lambda r: r.drive.effective_radius,
}
"""What the equations of motion divide by."""
_MOST = 1e6
"""No rig has a place, speed, voltage or force of more than this [SI]; such a number is a slip,
and overflows in the powers of the equations of motion."""
_LIMITS = 5.0
"""Times a drive's limit from which on a command is a slip of the unit [1]."""
_LONGEST = 3600.0
"""Longest interval in which inputs are held [s]; more is a time stamp of the wall clock."""


def check_shape(value: Any, shape: tuple[int | str, ...], *, name: str, unit: str) -> None:
    """Refuse an array of another shape.

    Args:
        value: The array.
        shape: Its lengths; a letter for one that may be any.
        name: Its name, for the message.
        unit: Its unit, for the message.

    Raises:
        ValueError: If it has another shape.
    """
    got = jnp.shape(value)
    matches = len(got) == len(shape) and all(
        isinstance(length, str) or length == own for own, length in zip(got, shape, strict=True)
    )
    if not matches:
        wanted = ", ".join(map(str, shape)) + ("," if len(shape) == 1 else "")
        raise ValueError(
            f"`{name}` [{unit}] must have the shape ({wanted}), got {got}. Pick the columns "
            "by name, and put several runs side by side with `jax.vmap`."
        )


def check_finite(value: Any, *, name: str, unit: str, most: float = _MOST) -> None:
    """Refuse numbers that aren't finite or that no rig has, where they are known.

    Args:
        value: The numbers.
        name: Their name, for the message.
        unit: Their unit, for the message.
        most: The largest of either sign that one may be.

    Raises:
        ValueError: If one of them is known to be such.
    """
    numbers = concrete(value)
    if isinstance(numbers, jax.core.Tracer):
        return
    sizes = np.abs(np.asarray(numbers, dtype=float))
    wrong = np.argwhere(~((sizes <= most) & np.isfinite(sizes)))
    if len(wrong):
        first = tuple(int(i) for i in wrong[0])
        place = f"{name}{list(first)}" if first else name
        raise ValueError(
            f"`{place}` must be finite [{unit}] and {most:g} at most, got "
            f"{np.asarray(numbers)[first]} in {len(wrong)} of {np.size(numbers)} places. "
            "Fill or cut out what is missing, and see to the unit."
        )


def check_commands(robot: Robot, voltage: Any) -> None:
    """Refuse commands that no drive gives, where they are known.

    Args:
        robot: The robot.
        voltage: The commands [V].

    Raises:
        ValueError: If one is known to be many times the drives' limit.
    """
    numbers, limit = concrete(voltage), concrete(robot.drive.voltage_limit)
    if isinstance(numbers, jax.core.Tracer) or isinstance(limit, jax.core.Tracer):
        return
    most = float(np.max(np.abs(numbers), initial=0.0))
    if most > _LIMITS * float(limit):
        raise ValueError(
            f"`voltage` must be what a drive gives [V], got {most:g} V, expected at most its "
            f"`voltage_limit` of {float(limit):g} V. See to the unit, or state another limit."
        )


def possible_duration(
    duration: Float[Array, "*shape"], *, name: str = "duration"
) -> Float[Array, "*shape"]:
    """Lengths of time, none below zero.

    Args:
        duration: The lengths [s].
        name: Their name, for the message.

    Returns:
        The lengths; NaN throughout where they are traced and one is below zero.

    Raises:
        ValueError: If one is known to be below zero, not finite or longer than an hour.
    """
    check_finite(duration, name=name, unit="s")
    numbers = concrete(duration)
    known = not isinstance(numbers, jax.core.Tracer) and np.size(numbers)
    ends = f", got {np.min(numbers):g} to {np.max(numbers):g}" if known else ""
    message = (
        f"`{name}` must not be negative [s] nor longer than {_LONGEST:g} s{ends}: time stamps "
        "that go back are out of order. Sort the rows by time before taking differences."
    )
    return refuse(duration, ~((numbers >= 0) & (numbers <= _LONGEST)).all(), message)


def possible_substeps(substeps: int) -> int:
    """How many steps an interval of inputs has, one at least.

    Args:
        substeps: The number.

    Returns:
        The number.

    Raises:
        ValueError: If it is below 1.
    """
    if substeps < 1:
        raise ValueError(
            f"`substeps` must be 1 or more [steps in an interval], got {substeps}. Take 1 for "
            "inputs every 5 ms, 5 for inputs every 25 ms."
        )
    return substeps


def check_start(robot: Robot, start: State) -> None:
    """Refuse a robot or a start that can't be one.

    Args:
        robot: One robot; its numbers are scalars.
        start: One state.

    Raises:
        ValueError: If a shape is another, a number is known not to be finite, or what is
            divided by is known not to be above zero.
    """
    for path, leaf in jax.tree_util.tree_leaves_with_path(eqx.filter(robot, eqx.is_array)):
        name = "robot" + jax.tree_util.keystr(path)
        check_shape(leaf, (), name=name, unit="SI")
        check_finite(leaf, name=name, unit="SI", most=np.inf)
    for name, pick in _ABOVE_ZERO.items():
        number = concrete(pick(robot))
        if not isinstance(number, jax.core.Tracer) and not number > 0:
            raise ValueError(
                f"`robot.{name}` must be above zero [SI], got {float(number):g}: the equations "
                "of motion divide by it. See `scdpr_jax.QUANTITIES` for its unit."
            )
    for name, carriage in (
        ("lower_carriage", robot.lower_carriage),
        ("upper_carriage", robot.upper_carriage),
    ):
        number = concrete(carriage.friction.coefficient)
        if not isinstance(number, jax.core.Tracer) and number < 0:
            raise ValueError(
                f"`robot.{name}.friction.coefficient` must not be negative [1], got "
                f"{float(number):g}: friction would drive the carriage. Give 0 for none."
            )
    for name, unit in (("position", "m, rad"), ("velocity", "m/s, rad/s")):
        check_shape(getattr(start, name), (5,), name=f"start.{name}", unit=unit)
        check_finite(getattr(start, name), name=f"start.{name}", unit=unit)
