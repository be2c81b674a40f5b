r"""What is left to do for a robot as its leg ends: vibration, and a rest that is another.

The upper carriage holds, once its friction has it, and what vibrates about the line between the
carriages are two modes of $[x_e, \delta_e]$. Their amplitudes are known from the state as the
leg ends, six numbers a robot, without a second of simulated vibration; and unlike that one's
samples they are smooth in the state, so that a search finds its way.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.engines.led_stepping import Undriven, whole_position
from scdpr_jax.robot.cable import loop_forces
from scdpr_jax.robot.parameters import Robot

TURNED = 20e-3
"""Arm at which a rotation counts as a displacement [m]: what isn't in $x_e$ isn't at rest."""


class Arrival(NamedTuple):
    """What a robot does as its leg ends, held by both carriages."""

    vibration: Float[Array | np.ndarray, "... 4"]
    r"""Displacements $\eta_i$ and velocities over frequencies $\dot\eta_i / \omega_i$ of both
    modes, as they move $x_e$ and, a little, turn the end-effector [m]."""
    sliding: Float[Array | np.ndarray, "..."]
    """Velocity of the upper carriage [m/s]."""
    rest: Float[Array | np.ndarray, "..."]
    """Where the end-effector rests, less the target [m]."""


class Goal(NamedTuple):
    """Where a leg is to end."""

    lower: Float[Array | np.ndarray, "..."]
    """Where the lower carriage holds [m]."""
    place: Float[Array | np.ndarray, "..."]
    """Where the end-effector is to rest, $x_e$ [m]."""
    height: Float[Array | np.ndarray, "..."]
    """At which height [m]."""


def arrival(robot: Robot, state: Undriven, goal: Goal) -> Arrival:
    r"""What a robot does as its leg ends.

    About the line between the carriages, of slope $s = (q_3 - q_4) / H$, with
    $e = [x_e - q_3 + s y_e,\; \delta_e - \arctan s]$ and the stiffness $K$ there,

    $$ \eta = \Phi^T M e, \qquad \Phi^T M \Phi = 1, \qquad \Phi^T K \Phi = \Omega^2 $$

    Args:
        robot: The robot.
        state: Its state as the leg ends.
        goal: Where that is to be.

    Returns:
        What it does.
    """
    about = _about_line(robot, state, goal)
    # In metres of x_e; a mode that only turns the end-effector counts, too.
    arm = jnp.square(TURNED) / robot.end_effector.mass
    size = jnp.sqrt(jnp.square(about.shapes[0]) + arm)
    return Arrival(
        jnp.concatenate([size * about.displaced, size * about.moving]),
        state.velocity[2],
        about.rest - goal.place,
    )


def vibration(robot: Robot, state: Undriven, goal: Goal) -> Array:
    r"""Largest peak to peak of $x_e$ with both carriages held [m].

    The sum of both modes' $2 |\varphi_{xi}| \sqrt{\eta_i^2 + (\dot\eta_i / \omega_i)^2}$, which
    they come to sooner or later: their frequencies have no common measure.

    Args:
        robot: The robot.
        state: Its state as the leg ends.
        goal: Where that is.

    Returns:
        Peak to peak [m].
    """
    about = _about_line(robot, state, goal)
    size = jnp.sqrt(jnp.square(about.displaced) + jnp.square(about.moving))
    return 2 * jnp.sum(jnp.abs(about.shapes[0]) * size)


class _AboutLine(NamedTuple):
    """A state in the modes about the line between the carriages."""

    shapes: Float[Array, "2 2"]
    displaced: Float[Array, "2"]
    r"""$\eta_i$ [m √kg]."""
    moving: Float[Array, "2"]
    r"""$\dot\eta_i / \omega_i$ [m √kg]."""
    rest: Array
    """Where the end-effector is on the line, $x_e$ [m]."""


def _about_line(robot: Robot, state: Undriven, goal: Goal) -> _AboutLine:
    _, _, upper = jnp.unstack(state.position)
    slope = (goal.lower - upper) / robot.frame.height
    line = jnp.stack([goal.lower - slope * goal.height, _arctangent(slope)])
    shapes, frequencies = modes(robot, upper, goal, line)
    mass = jnp.stack([robot.end_effector.mass, robot.end_effector.inertia])
    displaced, moving = (
        jnp.sum(shapes * (mass * own)[:, None], axis=0)
        for own in (state.position[:2] - line, state.velocity[:2])
    )
    return _AboutLine(shapes, displaced, moving / frequencies, line[0])


def modes(
    robot: Robot, upper: Array, goal: Goal, line: Float[Array, "2"]
) -> tuple[Float[Array, "2 2"], Float[Array, "2"]]:
    r"""Modes of end-effector and rotation with both carriages held.

    Args:
        robot: The robot.
        upper: Where the upper carriage is held [m].
        goal: Where the lower one is, and the height.
        line: $[x_e, \delta_e]$ at rest [m, rad].

    Returns:
        Shapes, a column each, of modal mass one [1/√kg; 1/√(kg m²)], and angular frequencies,
        the higher one first [rad/s].
    """

    def pull(place: Float[Array, "2"]) -> Float[Array, "2"]:
        position = whole_position(
            jnp.stack([place[0], place[1], upper]), goal.lower, goal.height
        )
        return loop_forces(robot, position).pull[:2]

    stiffness = -jax.jacfwd(pull)(line)
    body = robot.end_effector
    scale = 1 / jnp.sqrt(jnp.stack([body.mass, body.inertia]))
    unit = stiffness * scale[:, None] * scale[None]
    mean, half = (unit[0, 0] + unit[1, 1]) / 2, (unit[0, 0] - unit[1, 1]) / 2
    coupling = unit[0, 1]
    radius = jnp.sqrt(jnp.square(half) + jnp.square(coupling) + jnp.finfo(half.dtype).tiny)
    # The larger one of cosine and sine by the root, the other by their product: no root of 0.
    larger = jnp.sqrt((1 + jnp.abs(half) / radius) / 2)
    smaller = coupling / (2 * radius * larger)
    side = jnp.where(coupling < 0, -1.0, 1.0)
    cosine = jnp.where(half < 0, side * smaller, larger)
    sine = jnp.where(half < 0, side * larger, smaller)
    turned = jnp.stack([jnp.stack([cosine, -sine]), jnp.stack([sine, cosine])])
    # A slack or upside-down robot has no frequency; far from rest a search may come there.
    squares = jnp.maximum(jnp.stack([mean + radius, mean - radius]), 1.0)
    return turned * scale[:, None], jnp.sqrt(squares)


def _arctangent(slope: Array) -> Array:
    """Of slopes that friction holds; for 0.1 it is right to 1e-10."""
    square = jnp.square(slope)
    return slope * (1 - square * (1 / 3 - square * (1 / 5 - square / 7)))
