"""The one problem that every contender is given, and its answer."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import State, rest

FREE = ("friction_coefficient", "drive_inertia", "drive_damping", "effective_pretension")
"""What differs from run to run, and what Jacobians and fits are by."""
MIDDLE = np.array([0.005, 1.2734e-2, 0.2124, 350.0])
"""Its middle: the prototype's drives, a stiff loop that slides [1, kg m², N m s, N]."""
SPREAD = 0.3
"""How far a run's values lie from the middle at the most [1]."""
LOG, PARTS, ROWS = 25e-3, 5, 80
"""Interval of the log [s], steps in it (200 Hz), and its number: 2 s."""
DURATION = ROWS * LOG
"""Length of a run [s]."""
TORQUE_STEP = np.where(np.arange(ROWS)[:, None] < ROWS // 2, 6.0, 0.0) * np.ones(2)
"""Commands: 6 V on both drives for a second, then a second of coasting [V]."""
X, HEIGHT = 0.40, 0.45
"""Where a run starts at rest [m]."""
ARM = 0.1405
"""By which a tilt is counted as a length: the attachments' distance [m]."""
REFINED = 20
"""By how much smaller the answer's steps are: 4 kHz, good to some 1e-10 m."""


def drawn(count: int) -> Float[np.ndarray, "runs 4"]:
    """Values of `FREE` for some runs, the same at every call.

    Args:
        count: Number of runs.

    Returns:
        One run a row.
    """
    random = np.random.default_rng(20230415)
    return MIDDLE * random.uniform(1 - SPREAD, 1 + SPREAD, (count, len(FREE)))


def robot_of(values: Float[Array, "4"]) -> Robot:
    """The prototype with the values of a run.

    Args:
        values: Values of `FREE`.

    Returns:
        The robot, with exact friction, in the values' precision.
    """
    prototype = jax.tree.map(lambda leaf: leaf.astype(values.dtype), consistent())
    return replace(prototype, dict(zip(FREE, values, strict=True)))


def start_of(robot: Robot) -> State:
    """The start of every run.

    Args:
        robot: The robot.

    Returns:
        Aligned, at rest.
    """
    at = jnp.asarray(X, robot.frame.width.dtype)
    return rest(robot, at, at, jnp.asarray(HEIGHT, at.dtype))


def error(positions: Float[np.ndarray, "..."], truth: Float[np.ndarray, "..."]) -> float:
    """Largest error of a position, a tilt counted as the way of the attachments.

    Args:
        positions: Positions.
        truth: What they should be.

    Returns:
        The error [m].
    """
    return float(np.abs((positions - truth) * np.array([1.0, ARM, 1.0, 1.0, 1.0])).max())
