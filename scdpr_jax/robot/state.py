r"""The robot's coordinates $q = [x_e, \delta_e, q_3, q_4, y_e]$, their velocities and names.

The loop is clamped below the end-effector and inextensible, so that the driver pulleys follow
the lower carriage and the height: five coordinates are enough, and no motor angle is among
them. Every array of them has its coordinates along the last axis, in this order.
"""

from collections.abc import Mapping
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.robot.fields import concrete, measured, real, refuse, si
from scdpr_jax.robot.parameters import Robot

X, TILT, LOWER, UPPER, HEIGHT = range(5)
r"""Places of $x_e$, $\delta_e$, $q_3$, $q_4$ and $y_e$ along the last axis."""

Coordinates = Float[Array | np.ndarray, "*shape 5"]
"""Positions or velocities, the coordinates along the last axis [m, rad]."""
Pair = Float[Array | np.ndarray, "*shape 2"]
"""Two of them, likewise."""


def pose(coordinates: Coordinates) -> Pair:
    """The end-effector's $[x_e, y_e]$ of positions or velocities.

    Args:
        coordinates: Coordinates, or their velocities, along the last axis [m, rad].

    Returns:
        Both along the last axis [m].
    """
    return coordinates[..., X::HEIGHT]


def carriages(coordinates: Coordinates) -> Pair:
    """The carriages' $[q_3, q_4]$ of positions or velocities.

    Args:
        coordinates: Coordinates, or their velocities, along the last axis [m, rad].

    Returns:
        Both along the last axis [m].
    """
    return coordinates[..., LOWER:HEIGHT]


def driven(coordinates: Coordinates) -> Pair:
    """What the driver pulleys follow, $[q_3, y_e]$, of positions or velocities.

    Args:
        coordinates: Coordinates, or their velocities, along the last axis [m, rad].

    Returns:
        Both along the last axis [m].
    """
    return coordinates[..., LOWER :: HEIGHT - LOWER]


def with_coordinates(
    vector: Float[Array, "5"], others: Mapping[int, Float[Array, ""]]
) -> Float[Array, "5"]:
    """A vector of which some coordinates are others.

    Args:
        vector: Positions or velocities of one robot.
        others: What takes the place of a coordinate's.

    Returns:
        The vector.
    """
    return jnp.stack([others.get(i, value) for i, value in enumerate(jnp.unstack(vector))])


def possible_height(robot: Robot, height: Float[Array, ""]) -> Float[Array, ""]:
    """A height of the end-effector's centre between the frame's guides.

    Args:
        robot: The robot.
        height: The height [m].

    Returns:
        The height; NaN where it is traced and isn't within the frame.

    Raises:
        ValueError: If it isn't one number, or is known not to be within the frame.
    """
    place = _single(height, "height")
    known, top = concrete(place), concrete(robot.frame.height)
    message = (
        f"`height` must be within the frame [m], got {measured(place, 'm')}. Give a height "
        f"from 0 to the frame's, {measured(top, 'm')}."
    )
    return refuse(place, ~((known >= 0) & (known <= top)), message)


def _possible_place(robot: Robot, value: Any, name: str) -> Float[Array, ""]:
    """A carriage's place in the frame, or about it: a simulation may begin a little outside."""
    place = _single(value, name)
    known, width = concrete(place), concrete(robot.frame.width)
    message = (
        f"`{name}` must be in the frame [m], got {measured(place, 'm')}. Give a place from 0 "
        f"to the frame's width, {measured(width, 'm')}."
    )
    return refuse(place, ~((known >= -width) & (known <= 2 * width)), message)


def _single(value: Any, name: str) -> Float[Array, ""]:
    place = real(value)
    if place.ndim:
        raise ValueError(
            f"`{name}` must be one number [m], got the shape {place.shape}. Put several poses "
            "side by side with `jax.vmap`."
        )
    return place


class State(eqx.Module):
    """Coordinates and velocities of the robot."""

    position: Float[Array, "... 5"] = eqx.field(converter=real, metadata=si("m, rad", "q"))
    r"""$[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m]."""
    velocity: Float[Array, "... 5"] = eqx.field(
        converter=real, metadata=si("m/s, rad/s", r"\dot q")
    )
    """Its time derivative [m/s, rad/s, m/s, m/s, m/s]."""

    @property
    def pose(self) -> Pair:
        """The end-effector's place $[x_e, y_e]$ [m]."""
        return pose(self.position)

    @property
    def tilt(self) -> Float[Array | np.ndarray, "..."]:
        r"""The end-effector's rotation $\delta_e$ [rad]."""
        return self.position[..., TILT]

    @property
    def carriages(self) -> Pair:
        """The carriages' places $[q_3, q_4]$ [m]."""
        return carriages(self.position)

    @property
    def driven(self) -> Pair:
        """What the driver pulleys follow, $[q_3, y_e]$ [m]."""
        return driven(self.position)


def rest(
    robot: Robot,
    lower: Float[Array, ""],
    upper: Float[Array, ""],
    height: Float[Array, ""],
) -> State:
    r"""The robot at rest with its carriages at given places.

    The end-effector has no friction, so at rest it lies on the straight line between the
    carriages: $\alpha = \beta = \gamma = \delta_e$. Friction holds the carriages while
    $|\tan\gamma| \le \mu$.

    Args:
        robot: The robot.
        lower: Place $q_3$ of the lower carriage [m].
        upper: Place $q_4$ of the upper carriage [m].
        height: Height $y_e$ of the end-effector [m].

    Returns:
        State at rest.

    Raises:
        ValueError: If a place isn't one number, isn't finite, or the height isn't within the
            frame; NaN where it is traced.
    """
    lower, upper = (
        _possible_place(robot, place, name)
        for place, name in ((lower, "lower"), (upper, "upper"))
    )
    height = possible_height(robot, height)
    slope = (lower - upper) / robot.frame.height
    position = jnp.stack([lower - slope * height, jnp.arctan(slope), lower, upper, height])
    return State(position, jnp.zeros_like(position))
