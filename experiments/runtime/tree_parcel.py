"""A tree of arrays as plain data, and back: its leaves by numbers.

How leaves belong together is a program's business: who unpacks them makes the structure itself.
"""

from collections.abc import Mapping
from typing import Any

import jax
import numpy as np


def tree_arrays(
    name: str, tree: Any, structure: jax.tree_util.PyTreeDef
) -> dict[str, np.ndarray]:
    """A tree's leaves by names.

    Args:
        name: What the tree is called among other arrays.
        tree: The tree.
        structure: How its leaves belong together, as `tree_of` will be told it.

    Returns:
        The arrays.

    Raises:
        ValueError: If the tree has another structure.
    """
    leaves, own = jax.tree.flatten(tree)
    if own != structure:
        raise ValueError(f"a tree {name!r} has another structure, got {own}.")
    return {f"{name} {number}": np.asarray(leaf) for number, leaf in enumerate(leaves)}


def tree_of(
    name: str, arrays: Mapping[str, np.ndarray], structure: jax.tree_util.PyTreeDef
) -> Any:
    """The tree that arrays are of.

    Args:
        name: What it is called.
        arrays: What `tree_arrays` made of it, among others.
        structure: How its leaves belong together.

    Returns:
        The tree; its leaves are NumPy arrays.
    """
    return jax.tree.unflatten(
        structure, [arrays[f"{name} {number}"] for number in range(structure.num_leaves)]
    )
