r"""How a robot answers friction that differs, within a step, from the one it was stepped with.

A step is made on the branches that the contacts begin it on; events then say how much the true
friction deviates, $d(\theta)$. The deviation acts through the robot's own response at frozen
coefficients, of which only the moments $E_k = \int_0^1 (1-\theta)^k d(\theta)\,d\theta$ are
needed: a step needs no second pass. Stepping anew from event to event would be simpler, but
costs a Runge-Kutta step for every event, and in a batch every run would pay for each.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.robot.state import State, with_coordinates

Moments = tuple[Float[Array, ""], Float[Array, ""], Float[Array, ""], Float[Array, ""]]
r"""$E_0$ to $E_3$ of what a friction deviates by [m/s]."""


class Deviation(NamedTuple):
    """What the true friction does to a coordinate beyond the assumed one."""

    moments: Moments
    r"""$E_k = \int_0^1 (1-\theta)^k d(\theta)\,d\theta$, d the difference, up to E_3 [m/s]."""
    pulls: tuple[Float[Array, ""], Float[Array, ""]]
    """E_2 and E_3 with what the assumed friction lacked while it held the coordinate: that
    moves whatever the cables tie to it, and not the coordinate itself [m/s]."""


def deviating(moments: Moments, unheld: Float[Array, ""] | None = None) -> Deviation:
    """The deviation with these moments.

    Args:
        moments: E_0 to E_3 [m/s].
        unheld: What the assumed friction lacked of the load's square term [m/s]; `None` for
            nothing.

    Returns:
        The deviation.
    """
    _, _, second, third = moments
    if unheld is None:
        return Deviation(moments, (second, third))
    # The moments of the square term are 2 k!/(k+3)!.
    return Deviation(moments, (second - unheld / 30, third - unheld / 60))


class Response(NamedTuple):
    """How the robot answers a coordinate with friction over a step, in units of the step."""

    damped: Float[Array, ""]
    """The coordinate's damping over its mass, times the step's length, $ch$ [1]."""
    coupling: Float[Array, "5"]
    r"""Acceleration of each coordinate per displacement of this one, times the step's length
    squared, $\kappa$ [1 for a displacement]; its own is among them."""


class Departure(NamedTuple):
    """How contacts leave the branches that they begin a step on."""

    deviations: Mapping[int, Deviation]
    """By the coordinate that feels them."""
    at_rest: Callable[[Float[Array, "5"]], Mapping[int, Float[Array, ""]]]
    """From velocities at the end to those by which what sticks is at rest to the bit."""


def answer(
    moments: Moments, damped: Float[Array, ""], coupling: Float[Array, ""] | float
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    r"""How a coordinate answers a deviation of its own friction [m/s].

    $$ \delta q / h = E_1 - ch E_2 / 2 + \kappa E_3 / 6, \qquad
       \delta v = E_0 - ch E_1 + \left((ch)^2 + \kappa\right) E_2 / 2 $$

    Args:
        moments: E_0 to E_3 [m/s].
        damped: Damping over mass, times the step's length, $ch$ [1].
        coupling: Acceleration of the coordinate per displacement of its own, times the step's
            length squared, $\kappa$ [1].

    Returns:
        Its displacement over the step's length and its velocity, to be added to the assumed
        motion's end.
    """
    zeroth, first, second, third = moments
    return (
        first - damped * second / 2 + coupling * third / 6,
        zeroth - damped * first + (jnp.square(damped) + coupling) * second / 2,
    )


def departed(
    end: State,
    departures: Sequence[Departure],
    *,
    duration: Float[Array, ""],
    responses: Mapping[int, Response],
) -> State:
    r"""The end of a step under the true friction.

    What is tied to a coordinate by the cables feels of its deviation

    $$ \delta x / h = \kappa E_3 / 6, \qquad \delta v = \kappa E_2 / 2 $$

    and the coordinate itself answers as `answer` has it. What sticks is then put to rest.

    Args:
        end: The end on the assumed branches [m, rad; m/s, rad/s].
        departures: How the contacts leave these.
        duration: Length of the step [s].
        responses: How the robot answers each coordinate that deviates.

    Returns:
        The true end.
    """
    position, velocity = end.position, end.velocity
    for i, deviation in (pair for each in departures for pair in each.deviations.items()):
        damped, coupling = responses[i]
        second, third = deviation.pulls
        moved, sped = answer(deviation.moments, damped, coupling[i])
        position += duration * with_coordinates(coupling * third / 6, {i: moved})
        velocity += with_coordinates(coupling * second / 2, {i: sped})
    for departure in departures:
        velocity = with_coordinates(velocity, departure.at_rest(velocity))
    return State(position, velocity)
