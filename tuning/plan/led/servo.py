r"""How far the lower carriage is from where it is led, on robots that aren't as fitted.

The feed-forward is the fitted robot's. Another one's cables pull otherwise, its carriage rubs
otherwise, and what is missing is left to the PD:

$$ m \ddot e + (d + k_d)\,\dot e + k_p\,e = \Delta F, \qquad k_p = 2 K_p k_v / r^2, \quad
   k_d = 2 K_d k_v / r^2 $$

with the deviation $e$ of $q_3$ and $\Delta F$ what acts on it beyond the fitted robot's. (What
acts on the height is of second order in the inclinations, and so small.) Those are tenths of a
millimetre, and after a leg they vibrate as much as all the rest: a plan that takes them for
nothing leaves several times the vibration, and the more the softer the gains are.

Within a step $\Delta F$ is held, and the deviation moves exactly under it, so that stiff gains
need no short steps. Where the reference rests, friction holds the carriage as it is.
"""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax import native
from scdpr_jax.command.controller import PD
from scdpr_jax.engines.led_stepping import Lead, Undriven, step, whole_position
from scdpr_jax.engines.stepping import friction_coefficients
from scdpr_jax.robot.cable import loop_forces
from scdpr_jax.robot.dynamics import dampings, masses
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import LOWER
from tuning.plan.feedforward import TURN_ROUND

_TERMS, _SQUARINGS = 8, 8
"""Of the exponential: a step of 10 ms is right to rounding up to frequencies of 1 kHz."""


class Servo(NamedTuple):
    """A PD against the lower carriage."""

    stiffness: Float[Array | np.ndarray, "..."]
    """Stiffness over mass, $k_p / m$ [1/s²]."""
    damping: Float[Array | np.ndarray, "..."]
    """Damping over mass, $(d + k_d) / m$ [1/s]."""
    mass: Float[Array | np.ndarray, "..."]
    """Mass that it moves [kg]."""


class Transition(NamedTuple):
    """How the deviation moves in a time under a held force."""

    position: Float[Array | np.ndarray, "... 3"]
    """To the deviation: by itself, by its velocity [s], by a force [m/N]."""
    velocity: Float[Array | np.ndarray, "... 3"]
    """To its velocity, likewise."""


class Deviation(NamedTuple):
    """By how much the lower carriage deviates."""

    position: Float[Array | np.ndarray, "..."]
    """Its deviation [m]."""
    velocity: Float[Array | np.ndarray, "..."]
    """That one's velocity [m/s]."""


def servo(robot: Robot, controller: PD) -> Servo:
    """A PD against what it moves.

    Args:
        robot: The robot.
        controller: The controller; its filter and its period don't matter here.

    Returns:
        Stiffness and damping.
    """
    drive = robot.drive
    per_gain = 2 * np.asarray(drive.torque_per_volt) / np.square(drive.effective_radius)
    mass, damping = (np.asarray(of(robot))[LOWER] for of in (masses, dampings))
    proportional = per_gain * np.asarray(controller.proportional_gain)
    derivative = per_gain * np.asarray(controller.derivative_gain)
    return Servo(proportional / mass, (damping + derivative) / mass, mass)


def transition(own: Servo, time: Array) -> Transition:
    r"""How the deviation moves in a time, $\exp(A t)$ of its state and the force.

    By its Taylor series over $2^{-8}$ of the time, squared eight times.

    Args:
        own: The servo.
        time: The time [s].

    Returns:
        The transition.
    """
    short = time / 2**_SQUARINGS
    none = jnp.zeros_like(own.mass)
    # Rows of the matrix that isn't constant: derivatives of deviation and velocity.
    rate = ((none, none + 1, none), (-own.stiffness, -own.damping, 1 / own.mass))
    one = ((none + 1, none, none), (none, none + 1, none))
    sum_, term = one, one
    for power in range(1, _TERMS + 1):
        scaled = _times(term, rate, held=0.0)
        term = tuple(tuple(short / power * x for x in row) for row in scaled)
        sum_ = tuple(tuple(map(jnp.add, *rows)) for rows in zip(sum_, term, strict=True))
    for _ in range(_SQUARINGS):
        sum_ = _times(sum_, sum_, held=1.0)
    return Transition(*(jnp.stack(row) for row in sum_))


def _times(first: tuple, second: tuple, *, held: float) -> tuple:
    """A product of such matrices, whose last row is that of a force: held, or no rate."""
    return tuple(
        tuple(
            row[0] * second[0][k] + row[1] * second[1][k] + (held * row[2] if k == 2 else 0.0)
            for k in range(3)
        )
        for row in first
    )


def led_force(
    robot: Robot, position: Float[Array, "5"], velocity: Float[Array, ""]
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """What pulls at the lower carriage, and its largest friction.

    Args:
        robot: The robot.
        position: Its coordinates [m, rad, m, m, m].
        velocity: Where the lower carriage is led to, whose sign is its friction's [m/s].

    Returns:
        The cables' pull less friction [N], and friction [N].
    """
    loop = loop_forces(robot, position)
    limit = friction_coefficients(robot)[0] * loop.normal[0]
    return loop.pull[LOWER] - limit * jnp.tanh(velocity / TURN_ROUND), limit


class Led(NamedTuple):
    """What a step is told."""

    lead: Lead
    """Where the drives are to lead the rest."""
    velocity: Float[Array | np.ndarray, "..."]
    """Velocity of the lower carriage's reference at its beginning [m/s]."""
    force: Float[Array | np.ndarray, "..."]
    """The fitted robot's `led_force` there [N]."""


def deviating_step(
    parameters: tuple[Robot, Array, Servo, tuple[Transition, Transition]],
    carry: tuple[Undriven, Deviation],
    led: Led,
) -> tuple[tuple[Undriven, Deviation], Float[Array, ""]]:
    """A step of a robot that isn't as fitted.

    Args:
        parameters: The robot, the step's length [s], the servo, and its transitions to the
            middle and to the end.
        carry: State and deviations.
        led: Where it is led.

    Returns:
        State and deviations at the end, and the end-effector's place at the beginning [m].
    """
    robot, duration, own, (middle, end) = parameters
    state, deviation = carry
    lead = led.lead
    place = lead.lower[0] + deviation.position
    position = whole_position(state.position, place, lead.height[0])
    force, limit = led_force(robot, position, led.velocity)
    beyond = force - led.force
    # Where the reference rests, what friction can hold doesn't move.
    asked = beyond - own.mass * own.stiffness * deviation.position
    still = jnp.where((led.velocity == 0) & (jnp.abs(asked) <= limit), 1.0, 0.0)
    moving = (1 - still) * deviation.velocity
    half = _deviation(middle, deviation.position, moving, beyond, still)
    last = _deviation(end, deviation.position, moving, beyond, still)
    path = jnp.stack([deviation.position, half.position, last.position])
    aside = Lead(lead.lower + path, lead.height)
    return (step(robot, state, aside, duration), last), state.position[0]


def _deviation(
    moved: Transition, position: Array, velocity: Array, force: Array, still: Array
) -> Deviation:
    def row(weights: Array, before: Array) -> Array:
        after = weights[0] * position + weights[1] * velocity + weights[2] * force
        return still * before + (1 - still) * after

    stopped = jnp.zeros_like(velocity)
    return Deviation(row(moved.position, position), row(moved.velocity, stopped))


def transitions(own: Servo, duration: float) -> tuple[Transition, Transition]:
    """Transitions over half a step and over a whole one.

    Args:
        own: The servo.
        duration: Length of the step [s].

    Returns:
        Both, behind an axis of robots.
    """
    stacked = Servo(*(part[None] for part in own))
    _, both = native.Runs(_transition, stacked)((), np.array([[duration / 2, duration]]))
    middle, end = (Transition(*(part[:, k] for part in both)) for k in range(2))
    return middle, end


def _transition(own: Servo, _: tuple, time: Array) -> tuple[tuple, Transition]:
    return (), transition(own, time)
