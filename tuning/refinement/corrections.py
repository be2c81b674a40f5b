"""What may differ between a fit and the rig on its legs, and by how much it usually does.

A fit is as sharp as its noise, and a rig isn't of the model's class: cables give, grease is
cold, a tensioner creeps. The widths are what fits of elastic rigs were off by, not standard
errors of theirs.
"""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import replace, value


class Correction(NamedTuple):
    """A quantity that may be corrected."""

    name: str
    """Its name in `scdpr_jax.robot.quantities`."""
    width: float
    """Standard deviation of the correction before a leg is seen: of its log [1], or [SI]."""
    relative: bool
    """Whether it is corrected by a factor; otherwise by a sum, and not below zero."""


CORRECTIONS = (
    Correction("effective_pretension", 0.01, relative=True),
    Correction("friction_coefficient", 0.1, relative=True),
    Correction("upper_friction_coefficient", 0.05, relative=True),
    Correction("static_friction_surplus", 3e-3, relative=False),
    Correction("upper_carriage_damping", 0.2, relative=False),
    Correction("loop_stiffness", 100.0, relative=False),
    Correction("torque_per_volt", 0.02, relative=True),
)
"""Tension, friction of both carriages, the loop's elasticity, the drives' gain. The friction
coefficient is the lower carriage's, as the upper one has its own beside it."""


def with_corrections(robot: Robot, shares: Float[Array | np.ndarray, " n"]) -> Robot:
    """A corrected robot.

    Args:
        robot: The robot.
        shares: A correction over its width for each of `CORRECTIONS`; may be traced.

    Returns:
        The robot.
    """
    return replace(
        robot,
        {
            own.name: _corrected(
                value(robot, own.name), own, own.width * jnp.asarray(shares)[row]
            )
            for row, own in enumerate(CORRECTIONS)
        },
    )


def _corrected(number: Array, own: Correction, by: Array) -> Array:
    return number * jnp.exp(by) if own.relative else number + by


def lowest_shares(robot: Robot) -> Float[np.ndarray, " n"]:
    """Corrections below which a quantity would be negative.

    Args:
        robot: The robot.

    Returns:
        Each over its width.
    """
    return np.array(
        [
            -np.inf if own.relative else -float(value(robot, own.name)) / own.width
            for own in CORRECTIONS
        ]
    )
