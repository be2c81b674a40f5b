"""A robot as plain data, and back."""

import functools
from collections.abc import Mapping

import jax
import jax.numpy as jnp
import numpy as np

from experiments.runtime.tree_parcel import tree_arrays, tree_of
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.prototype import consistent

_NAME = "robot"


def robot_arrays(robot: Robot) -> dict[str, np.ndarray]:
    """A robot's leaves by names.

    Args:
        robot: The robot.

    Returns:
        The arrays.

    Raises:
        ValueError: If the robot isn't of the prototype's kind, exact friction and all.
    """
    if jax.tree.structure(robot) != _structure():
        raise ValueError(
            "the robot must have exact friction, got another kind. See "
            "`scdpr_jax.robot.parameters.exact`."
        )
    return tree_arrays(_NAME, robot, _structure())


def robot_of(arrays: Mapping[str, np.ndarray]) -> Robot:
    """The robot that arrays are of.

    Args:
        arrays: What `robot_arrays` made of it, among others.

    Returns:
        The robot, of the arrays' dtype.
    """
    return jax.tree.map(jnp.asarray, tree_of(_NAME, arrays, _structure()))


@functools.cache
def _structure() -> jax.tree_util.PyTreeDef:
    """How a robot's leaves belong together, which its leaves alone don't say."""
    with jax.enable_x64(True):
        return jax.tree.structure(consistent())
