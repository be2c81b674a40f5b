"""A robot as plain data, and back."""

from collections.abc import Mapping

import jax
import jax.numpy as jnp
import numpy as np

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
    leaves, structure = jax.tree.flatten(robot)
    if structure != _structure():
        raise ValueError(
            "the robot must have exact friction, got another kind. See "
            "`scdpr_jax.robot.parameters.exact`."
        )
    return {f"{_NAME} {number}": np.asarray(leaf) for number, leaf in enumerate(leaves)}


def robot_of(arrays: Mapping[str, np.ndarray]) -> Robot:
    """The robot that arrays are of.

    Args:
        arrays: What `robot_arrays` made of it, among others.

    Returns:
        The robot, of the arrays' dtype.
    """
    structure = _structure()
    leaves = [arrays[f"{_NAME} {number}"] for number in range(structure.num_leaves)]
    return jax.tree.unflatten(structure, [jnp.asarray(leaf) for leaf in leaves])


def _structure() -> jax.tree_util.PyTreeDef:
    """How a robot's leaves belong together, which its leaves alone don't say."""
    with jax.enable_x64(True):
        return jax.tree.structure(consistent())
