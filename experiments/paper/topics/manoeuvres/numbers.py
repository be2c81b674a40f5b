"""Table 3 with Figures 16 to 20: the controlled manoeuvres, in each reading of their times."""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.trajectory import TABLE_3_LEG_TIMES, Trajectory, table_3
from scdpr_jax.engines.closed_loop import joint_references, pulley_angles
from scdpr_jax.legs.command_law import CommandLaw
from scdpr_jax.legs.ensemble import single
from scdpr_jax.legs.leg import run_leg
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import TILT, pose

NAMES = ("horizontal", "vertical", "diagonal")
"""Manoeuvres of Table 3."""

ONE_LEG = dict(zip(NAMES, TABLE_3_LEG_TIMES, strict=True))
"""Time of a leg, Table 3's time read as that of one leg [s]."""

BOTH_LEGS = {name: time / 2 for name, time in ONE_LEG.items()}
"""Time of a leg, Table 3's time read as that of both legs [s]."""

GRAVITY = 9.81
"""Gravitational acceleration [m/s²]."""

_BEFORE, _AFTER, _PERIOD = 0.2, 1.0, 1e-3
_LONGEST = max(TABLE_3_LEG_TIMES)


class Tracked(NamedTuple):
    """A manoeuvre under the printed controller."""

    name: str
    """Name of the manoeuvre."""
    leg_time: float
    """Time of one leg [s]."""
    time: Float[np.ndarray, " samples"]
    """Time [s]."""
    reference: Float[np.ndarray, "samples 2"]
    """Commanded position [m]."""
    acceleration: Float[np.ndarray, " samples"]
    """Size of the commanded acceleration [m/s²]."""
    position: Float[np.ndarray, "samples 5"]
    r"""$[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m]."""
    angle_reference: Float[np.ndarray, "samples 2"]
    """Commanded pulley angles [rad]."""
    angle: Float[np.ndarray, "samples 2"]
    """Pulley angles [rad]."""
    voltage: Float[np.ndarray, "intervals 2"]
    """Commands [V]."""

    @property
    def error(self) -> Float[np.ndarray, " samples"]:
        """Distance from the reference, Eq. (26) [m]."""
        return np.linalg.norm(pose(self.position) - self.reference, axis=1)

    @property
    def tilt(self) -> float:
        """Largest rotation of the end-effector of either sign [rad]."""
        return float(np.abs(self.position[:, TILT]).max())

    @property
    def pushed(self) -> float:
        """Commanded acceleration where the error is largest, over its largest [1]."""
        return float(self.acceleration[np.argmax(self.error)] / self.acceleration.max())


@functools.cache
def tracked(
    name: str, leg_time: float, tension: float | None = None, gravity: float = 0.0
) -> Tracked:
    """A manoeuvre of Table 3, friction of 4.5 N on each carriage whatever the tension.

    Args:
        name: Name of the manoeuvre.
        leg_time: Time of one leg [s].
        tension: Effective pretension [N]; the default robot's for None.
        gravity: Gravitational acceleration [m/s²].

    Returns:
        The run.
    """
    robot = with_tension(consistent(), tension, gravity)
    trajectory = getattr(table_3(start_time=_BEFORE, leg_times=(leg_time,) * 3), name)
    # All runs are as long as the longest, so that one compilation does.
    time = _PERIOD * np.arange(round((_BEFORE + 2 * _LONGEST + _AFTER) / _PERIOD) + 1)
    run = _controlled(robot, trajectory, jnp.asarray(time))
    reference, acceleration, position, commanded, angle, voltage = map(np.asarray, run)
    kept = round((_BEFORE + 2 * leg_time + _AFTER) / _PERIOD) + 1
    return Tracked(
        name,
        leg_time,
        time[:kept],
        reference[:kept],
        np.linalg.norm(acceleration[:kept], axis=1),
        position[:kept],
        commanded[:kept],
        angle[:kept],
        voltage[: kept - 1],
    )


def with_tension(
    robot: Robot, tension: float | Float[Array, ""] | None, gravity: float
) -> Robot:
    """A robot at another tension, the friction force of its carriages as it was.

    Args:
        robot: The robot.
        tension: Effective pretension [N]; None for the robot's own.
        gravity: Gravitational acceleration [m/s²].

    Returns:
        The robot.
    """
    upright = eqx.tree_at(lambda r: r.gravity, robot, jnp.asarray(gravity))
    if tension is None:
        return upright
    force = value(robot, "friction_coefficient") * value(robot, "effective_pretension")
    return replace(
        upright, {"effective_pretension": tension, "friction_coefficient": force / tension}
    )


@eqx.filter_jit
def _controlled(
    robot: Robot, trajectory: Trajectory, time: Float[Array, " samples"]
) -> tuple[Float[Array, "_ _"], ...]:
    commands = CommandLaw(trajectory, published_pd()).commands(time.size)
    start = single(robot, commands.commanded[0]).start
    leg = run_leg(robot, start, commands)
    return (
        leg.reference,
        jax.vmap(trajectory.acceleration)(time),
        leg.states.position,
        joint_references(robot, leg.reference),
        jax.vmap(lambda state: pulley_angles(robot, state, start))(leg.states),
        leg.voltage,
    )
