r"""Starts that friction holds out of line.

At rest the end-effector lies on the line between the carriages, and Coulomb friction holds
that line at any slope within $\pm\mu$: what a leg leaves is the next one's start. A start is
told by where its end-effector rests and by the share of that slope, so that it stays a start
whatever the robot's friction is.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import State, rest

_GOLDEN = (np.sqrt(5) - 1) / 2
"""Multiples of it, without their whole part, fill an interval evenly whatever their number."""


def rest_out_of_line(
    robot: Robot, position: Float[Array, "2"], share: Float[Array, ""]
) -> State:
    r"""A robot at rest with its end-effector at a position, its carriages out of line.

    $$ q_3 = x_e + \sigma\mu\,y_e, \qquad q_4 = q_3 - \sigma\mu H $$

    Args:
        robot: The robot; the carriage of the lesser friction decides what is held.
        position: Where the end-effector rests, $[x_e, y_e]$ [m].
        share: Slope $\sigma$ of the line between the carriages over what friction holds [1],
            positive with the lower carriage ahead.

    Returns:
        The state.
    """
    x, y = position
    slope = share * held_slope(robot)
    place = x + slope * y
    return rest(robot, place, place - slope * robot.frame.height, y)


def held_slope(robot: Robot) -> Float[Array, "..."]:
    """Steepest slope of the line between the carriages that kinetic friction holds.

    Args:
        robot: The robot, or several stacked.

    Returns:
        The lesser of both carriages' coefficients [1].
    """
    lower, upper = robot.lower_carriage.friction, robot.upper_carriage.friction
    return jnp.minimum(lower.coefficient, upper.coefficient)


def steepest_held_slope(robot: Robot) -> float:
    """Steepest slope of that line that static friction of either carriage holds.

    Args:
        robot: The robot.

    Returns:
        The greater of both carriages' static coefficients [1].
    """
    carriages = (robot.lower_carriage, robot.upper_carriage)
    return max(
        float(own.friction.coefficient + own.friction.static_surplus) for own in carriages
    )


def even_shares(count: int) -> Float[np.ndarray, " count"]:
    """Numbers spread evenly over an interval, in an order that hangs on nothing else.

    Args:
        count: How many.

    Returns:
        Shares from -1 to 1.
    """
    return 2 * np.mod(_GOLDEN * np.arange(1, count + 1), 1.0) - 1
