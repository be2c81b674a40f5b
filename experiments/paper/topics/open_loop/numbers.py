"""Table 2 with Figures 13 and 14: a second of torque from four poses, open loop."""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.engines.stepping import Inputs, simulate
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import pose, rest
from scdpr_jax.statics.workspace import static_workspace

POSES = ((0.173, 0.300), (1.830, 0.300), (0.550, 0.234), (0.550, 0.921))
"""End-effector positions of Table 2 [m]."""

TORQUES = ((4.85, 4.85), (-4.78, -4.78), (1.87, -1.87), (-1.82, 1.82))
"""Torques of Table 2 [N m], applied for a second."""

TITLES = ("1: to the right", "2: to the left", "3: up", "4: down")
"""What the experiments do."""

_PERIOD, _ON, _INTERVALS = 1e-3, 1000, 2500


class OpenLoop(NamedTuple):
    """The four experiments of Table 2."""

    time: Float[np.ndarray, " samples"]
    """Time [s]."""
    torque: Float[np.ndarray, "experiments samples 2"]
    """Torques that the drives give [N m]."""
    position: Float[np.ndarray, "experiments samples 5"]
    r"""$[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m]."""

    def travel(self, experiment: int) -> float:
        """How far the end-effector has come when it rests.

        Args:
            experiment: Number of the experiment, from 1.

        Returns:
            Distance from the start [m].
        """
        run = pose(self.position[experiment - 1])
        return float(np.linalg.norm(run[-1] - run[0]))

    def margin(self, experiment: int) -> float:
        """Least distance of end-effector and carriages to the frame in the whole run.

        Args:
            experiment: Number of the experiment, from 1.

        Returns:
            Distance [m]; below zero there is a collision.
        """
        run = self.position[experiment - 1]
        region = static_workspace(consistent())
        (left, below), (right, above) = (np.asarray(c) for c in (region.lowest, region.highest))
        sideways = run[:, [0, 2, 3]]
        gaps = (
            sideways.min() - left,
            right - sideways.max(),
            run[:, 4].min() - below,
            above - run[:, 4].max(),
        )
        return float(min(gaps))


@functools.cache
def open_loop(radius: float = 73e-3) -> OpenLoop:
    """The experiments with the consistent robot, 1.5 s of coasting after the torque.

    Args:
        radius: Effective radius of the driver pulleys [m].

    Returns:
        The runs.
    """
    robot = replace(consistent(), {"effective_radius": radius})
    per_volt = float(robot.drive.torque_per_volt)
    on = (np.arange(_INTERVALS) < _ON)[:, None]
    voltage = np.array([on * np.array(pair) / per_volt for pair in TORQUES])
    position = _runs(robot, jnp.asarray(POSES), jnp.asarray(voltage))
    given = np.asarray(motor_torque(robot.drive, jnp.asarray(voltage)))
    return OpenLoop(
        _PERIOD * np.arange(_INTERVALS + 1),
        np.concatenate([given, given[:, -1:]], axis=1),
        np.asarray(position),
    )


@eqx.filter_jit
def _runs(
    robot: Robot, poses: Float[Array, "runs 2"], voltage: Float[Array, "runs intervals 2"]
) -> Float[Array, "runs samples 5"]:
    def run(
        pose: Float[Array, "2"], command: Float[Array, "intervals 2"]
    ) -> Float[Array, "samples 5"]:
        inputs = Inputs(jnp.full(_INTERVALS, _PERIOD), command, jnp.zeros_like(command[:, 0]))
        return simulate(robot, rest(robot, pose[0], pose[0], pose[1]), inputs).position

    return jax.vmap(run)(poses, voltage)
