"""The robot's named quantities, each with its unit and the leaves of a robot that it sets.

They are the names of `campaign.toml`'s `[robot]`, of `parameters.json` and of a report's
tables. A name may set several leaves: both carriages have one friction coefficient unless a
refinement gives the upper one its own. So refinements are replaced last, and a robot isn't a
flat record of numbers.
"""

import functools
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.stated.names import EVERY_QUANTITY as EVERY_QUANTITY
from scdpr_jax.robot.stated.names import QUANTITIES as QUANTITIES
from scdpr_jax.robot.stated.names import REFINEMENTS as REFINEMENTS
from scdpr_jax.robot.stated.names import Quantity as Quantity
from scdpr_jax.robot.stated.names import quantity as quantity


def value(robot: Robot, name: str) -> Float[Array, "..."]:
    """The robot's value of a named quantity.

    Args:
        robot: The robot.
        name: A name of `QUANTITIES`.

    Returns:
        Its value [in the quantity's unit].

    Raises:
        ValueError: If the name is unknown.
    """
    return quantity(name).leaves(robot)[0]


def replace(robot: Robot, values: dict[str, Any]) -> Robot:
    """The robot with some of its quantities set anew.

    Args:
        robot: The robot to start from.
        values: New value [in the quantity's SI unit] by name; may be traced.

    Returns:
        A robot in which every leaf of these quantities is replaced.

    Raises:
        ValueError: If a name is unknown.
    """
    leaves, structure = jax.tree.flatten(robot)
    refining = {refinement.name for refinement in REFINEMENTS}
    for name, number in sorted(values.items(), key=lambda item: item[0] in refining):
        places = _places(structure, name)
        number = jnp.asarray(number, dtype=leaves[places[0]].dtype)
        for place in places:
            leaves[place] = number
    return jax.tree.unflatten(structure, leaves)


@functools.cache
def _places(structure: jax.tree_util.PyTreeDef, name: str) -> tuple[int, ...]:
    """Which leaves of a robot a quantity sets."""
    numbered = jax.tree.unflatten(structure, range(structure.num_leaves))
    return quantity(name).leaves(numbered)
