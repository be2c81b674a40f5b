"""Robots as they might be, at rest before a leg: one ensemble, however it is made.

A grid of variations (`varied`), the draws of a covariance (`scdpr_jax.legs.draws`) and those
of a posterior (`with_values`) all give robots. Stacked with their starts and weights they are
an `Ensemble`, of which `jax.vmap` sees one robot.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from scdpr_jax.legs.starts import rest_out_of_line
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import State


class Ensemble(eqx.Module):
    """Robots at rest as they might be, one a row; as NumPy arrays until they are run."""

    robot: Robot
    """The robots, stacked leaf by leaf."""
    position: Float[Array | np.ndarray, "... 2"] = eqx.field(metadata=si("m", "x_e, y_e"))
    """Where their end-effectors rest [m]."""
    out_of_line: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("1"))
    """Slopes of the lines between their carriages over what friction holds [1]."""
    weight: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("1"))
    """How much each counts [1]."""

    def __len__(self) -> int:
        return self.position.shape[0]

    @property
    def start(self) -> State:
        """State at rest of one robot; of an ensemble under `jax.vmap`."""
        return rest_out_of_line(self.robot, self.position, self.out_of_line)

    def rows(self, rows: Int[np.ndarray, " n"]) -> "Ensemble":
        """Some of the robots.

        Args:
            rows: Which.

        Returns:
            These.
        """
        return jax.tree.map(lambda leaf: leaf[rows], self)


@dataclasses.dataclass(frozen=True)
class Variation:
    """How a robot as it might be differs from the fitted one, and how it lies."""

    tension: float = dataclasses.field(default=1.0, metadata=si("1"))
    """Effective pretension over the fitted one [1]."""
    friction: float = dataclasses.field(default=1.0, metadata=si("1"))
    """Friction force of the carriages over the fitted one [1]."""
    out_of_line: float = dataclasses.field(default=0.0, metadata=si("1"))
    """Slope of the line between the carriages over what friction holds [1]."""
    weight: float = dataclasses.field(default=1.0, metadata=si("1"))
    """How much it counts [1]."""


def single(robot: Robot, position: Any) -> Ensemble:
    """One robot at rest in line, not stacked.

    Args:
        robot: The robot.
        position: Where its end-effector rests [m].

    Returns:
        The robot with its start.
    """
    place = jnp.asarray(position)
    zero = jnp.zeros((), place.dtype)
    return Ensemble(robot, place, zero, zero + 1)


def stacked(
    robots: Sequence[Robot],
    position: Any,
    *,
    out_of_line: Any = 0.0,
    weight: Any = 1.0,
) -> Ensemble:
    """An ensemble of robots.

    Args:
        robots: The robots.
        position: Where the end-effectors rest, one place each or one for all [m].
        out_of_line: Shares of the slopes that friction holds, likewise [1].
        weight: How much each counts, likewise [1].

    Returns:
        The ensemble.
    """
    count = len(robots)
    return Ensemble(
        jax.tree.map(lambda *leaves: np.stack(leaves), *robots),
        np.array(np.broadcast_to(np.asarray(position, dtype=float), (count, 2))),
        *(
            np.array(np.broadcast_to(np.asarray(share, dtype=float), (count,)))
            for share in (out_of_line, weight)
        ),
    )


def varied(robot: Robot, variations: Sequence[Variation], position: Any) -> Ensemble:
    """The robots of a grid of variations, all of them with their end-effector at one place.

    Args:
        robot: The fitted robot.
        variations: How each differs from it.
        position: Where the end-effectors rest [m].

    Returns:
        The ensemble.
    """
    return stacked(
        [vary(robot, each) for each in variations],
        position,
        out_of_line=[each.out_of_line for each in variations],
        weight=[each.weight for each in variations],
    )


def vary(robot: Robot, variation: Variation) -> Robot:
    r"""A robot as it might be.

    The friction force of a carriage is $4T\mu$ and what logs determine: another tension is no
    other force, so that the coefficients make up for it.

    Args:
        robot: The fitted robot.
        variation: How it differs from that.

    Returns:
        The robot.
    """
    scale = {
        "effective_pretension": variation.tension,
        "friction_coefficient": variation.friction / variation.tension,
        "upper_friction_coefficient": variation.friction / variation.tension,
    }
    return replace(robot, {name: by * float(value(robot, name)) for name, by in scale.items()})


def with_values(
    robot: Robot, names: Sequence[str], values: Float[np.ndarray, "draws names"]
) -> list[Robot]:
    """A robot with each draw's values of some quantities.

    Args:
        robot: The robot.
        names: Names of the quantities.
        values: Their values, a row for each draw [SI].

    Returns:
        The robots.
    """
    return [replace(robot, dict(zip(names, row.tolist(), strict=True))) for row in values]
