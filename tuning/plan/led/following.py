"""Robots whose lower carriage and height are led along a leg: what the rest of them does."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax import native
from scdpr_jax.engines.led_stepping import Lead, Undriven, step, whole_position
from scdpr_jax.robot.parameters import Robot
from tuning.plan.feedforward import inverse_dynamics, stretch
from tuning.plan.led.arrival import Goal, arrival, vibration
from tuning.plan.led.servo import Deviation, Led, Servo, deviating_step, led_force, transitions
from tuning.plan.profile import Moment


class Leader:
    """A robot whose own dynamics are inverted: its drives are where they are led."""

    def __init__(self, robot: Robot):
        """Nothing runs yet.

        Args:
            robot: The robot, stacked.
        """
        self._robot = robot
        self.commanding = native.Runs(_command, robot)
        """Commands [V] from the undriven coordinates and the led `Moment`, each by itself."""
        self._stretch = native.Runs(_stretched, robot)

    def steps(self, duration: float) -> native.Runs:
        """Steps along a leg.

        Args:
            duration: Their length [s].

        Returns:
            Runs from `Undriven` along a `Lead` and the led velocity of the lower carriage
            [m/s] to `Undriven`, with the undriven coordinates [m, rad, m] and `led_force` [N]
            as each step begins.
        """
        return native.Runs(_advance, (self._robot, np.array([duration])))

    def commands(
        self, positions: Float[np.ndarray, "1 n 3"], motion: Moment
    ) -> Float[np.ndarray, "n 2"]:
        """Commands at some instants, by dynamics inversion.

        Args:
            positions: The undriven coordinates [m, rad, m].
            motion: Of lower carriage and height, behind an axis of robots.

        Returns:
            The commands [V].
        """
        return self.commanding((), (positions, motion))[1][0]

    def stretches(
        self, positions: Float[np.ndarray, "1 n 3"], motion: Moment
    ) -> Float[np.ndarray, " n"]:
        """By how much the cables between drives and lower carriage give.

        Args:
            positions: The undriven coordinates [m, rad, m].
            motion: Of lower carriage and height, behind an axis of robots.

        Returns:
            What the drives are to be ahead of the lower carriage [m].
        """
        return self._stretch((), (positions, motion))[1][0]


class Followers:
    """Robots as they might be under the feed-forward of another one."""

    def __init__(self, robots: Robot, servo: Servo):
        """Nothing runs yet.

        Args:
            robots: The robots, stacked.
            servo: The PD that is left with what they do otherwise.
        """
        self._robots, self._servo = robots, servo

    def steps(self, duration: float, shifts: Float[np.ndarray, " robots"]) -> native.Runs:
        """Steps along a leg.

        Args:
            duration: Their length [s].
            shifts: How far each robot's lower carriage is from where it is led [m].

        Returns:
            Runs from `Undriven` and `Deviation` along `Led` to both, with the end-effectors'
            places $x_e$ as each step begins [m].
        """
        own = Servo(*(part[None] for part in self._servo))
        over = transitions(self._servo, duration)
        stiff = (self._robots, np.array([duration]), own, over)
        return native.Runs(_shifted_step, (shifts, stiff))


class Arriving:
    """Robots as their leg ends: runs of one step, which carries nothing."""

    def __init__(self, robots: Robot):
        """Nothing runs yet.

        Args:
            robots: The robots, stacked.
        """
        self.arrivals = native.Runs(_arriving, robots)
        """`Arrival` in a row from `Undriven`, the lower carriage's deviation [m] and `Goal`."""
        self.vibrations = native.Runs(_vibrating, robots)
        """Largest peak to peak of the end-effectors once both carriages hold [m], likewise."""


_Row = tuple[Lead, Float[Array, ""]]


def _advance(
    parameters: tuple[Robot, Array], state: Undriven, row: _Row
) -> tuple[Undriven, tuple[Float[Array, "3"], Float[Array, ""]]]:
    (robot, duration), (lead, velocity) = parameters, row
    position = whole_position(state.position, lead.lower[0], lead.height[0])
    force, _ = led_force(robot, position, velocity)
    return step(robot, state, lead, duration), (state.position, force)


def _shifted_step(
    parameters: tuple[Array, tuple], carry: tuple[Undriven, Deviation], led: Led
) -> tuple[tuple[Undriven, Deviation], Float[Array, ""]]:
    (shift, stiff), lead = parameters, led.lead
    return deviating_step(
        stiff, carry, led._replace(lead=Lead(lead.lower + shift, lead.height))
    )


def _command(
    robot: Robot, _: tuple, row: tuple[Float[Array, "3"], Moment]
) -> tuple[tuple, Float[Array, "2"]]:
    position, motion = row
    lower, height = motion.value
    whole = whole_position(position, lower, height)
    return (), inverse_dynamics(robot, whole, motion.slope, motion.curvature)


def _stretched(
    robot: Robot, _: tuple, row: tuple[Float[Array, "3"], Moment]
) -> tuple[tuple, Float[Array, ""]]:
    position, motion = row
    lower, height = motion.value
    return (), stretch(robot, whole_position(position, lower, height), motion)


_End = tuple[Undriven, Float[Array, ""], Goal]


def _arriving(robot: Robot, _: tuple, row: _End) -> tuple[tuple, Float[Array, "6"]]:
    made = arrival(robot, *_at_rest(row))
    return (), jnp.append(made.vibration, jnp.stack([made.sliding, made.rest]))


def _vibrating(robot: Robot, _: tuple, row: _End) -> tuple[tuple, Array]:
    return (), vibration(robot, *_at_rest(row))


def _at_rest(row: _End) -> tuple[Undriven, Goal]:
    """A state, and where the carriages hold: the lower one where it deviates to."""
    state, aside, goal = row
    return state, goal._replace(lower=goal.lower + aside)
