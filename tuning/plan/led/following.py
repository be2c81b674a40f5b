"""Robots whose lower carriage and height are led along a leg: what the rest of them does.

Several motions of a leg are followed side by side, each by all robots: arrays are behind an
axis of motions and one of robots, of length one where all share it.
"""

from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Float, Int, PyTree

from scdpr_jax import native
from scdpr_jax.engines.led_stepping import Lead, Undriven, step, whole_position
from scdpr_jax.robot.parameters import Robot
from tuning.plan.feedforward import inverse_dynamics, stretch
from tuning.plan.led.arrival import Arrival, Goal, arrival, vibration
from tuning.plan.led.servo import Deviation, Led, Servo, deviating_step, led_force, transitions
from tuning.plan.profile import Moment

Slopes = native.Slopes
"""Derivatives by the splines' coefficients, along the last axis."""


class Followed(NamedTuple):
    """How robots follow."""

    end: Undriven
    """State at the end of the leg."""
    aside: Deviation
    """By how much the lower carriage deviates there."""
    place: Float[np.ndarray, "motions robots steps"]
    """Where the end-effectors are at the beginning of each step, $x_e$ [m]."""


class Inverted(NamedTuple):
    """How a robot follows whose own dynamics are inverted; or derivatives of it."""

    run: Followed
    positions: Float[np.ndarray, "motions 1 steps 3 ..."]
    """The undriven coordinates at the beginning of each step [m, rad, m]."""
    force: Float[np.ndarray, "motions 1 steps ..."]
    """What pulls at the lower carriage, with friction, at the beginning of each step [N]."""


class Leader:
    """A robot whose own dynamics are inverted: its drives are where they are led."""

    def __init__(self, robot: Robot):
        """Nothing runs yet.

        Args:
            robot: The robot, stacked.
        """
        self._robot = _for_every_motion(robot)
        self._command = native.Runs(_command, self._robot, teams=True)
        self._stretch = native.Runs(_stretched, self._robot, teams=True)

    def steps(self, duration: float) -> native.Runs:
        """Steps of a length, for `follow`.

        Args:
            duration: The length [s].

        Returns:
            Runs of such steps.
        """
        return native.Runs(_advance, (self._robot, np.array([[duration]])), teams=True)

    def follow(
        self,
        steps: native.Runs,
        start: Undriven,
        lead: Lead,
        velocity: Float[np.ndarray, "motions 1 steps 2"],
    ) -> Inverted:
        """The robot led along a leg.

        Args:
            steps: See `steps`.
            start: Where it begins.
            lead: Where it is led, a row for each step.
            velocity: Of lower carriage and height as the steps begin [m/s].

        Returns:
            What it does.
        """
        end, (positions, force) = steps(start, (lead, velocity))
        return Inverted(Followed(end, _NONE, positions[..., 0]), positions, force)

    def follow_linearised(
        self,
        steps: native.Runs,
        start: Undriven,
        lead: Lead,
        velocity: Float[np.ndarray, "motions 1 steps 2"],
        *,
        along: Float[np.ndarray, "splines steps 3"],
        begun: Int[np.ndarray, " steps"],
    ) -> tuple[Inverted, Inverted]:
        """The same with derivatives by the coefficients of splines.

        Args:
            steps: See `steps`.
            start: Where it begins.
            lead: Where it is led.
            velocity: Of lower carriage and height as the steps begin [m/s].
            along: What each spline does to the lead's lower carriage [1].
            begun: How many of the splines have begun by the end of each step.

        Returns:
            What it does, and the derivatives.
        """
        still = np.zeros((1, 1, 1, 3))
        seeds = Slopes(Undriven(still, still), (Lead(along[None, None], None), None))
        (end, (positions, force)), slopes = steps.linearised(
            start, (lead, velocity), along=seeds, begun=begun
        )
        none = np.zeros((1, 1, len(along)))
        moved, pulled = slopes.rows
        aside = Followed(slopes.carried, Deviation(none, none), moved[..., 0, :])
        return (
            Inverted(Followed(end, _NONE, positions[..., 0]), positions, force),
            Inverted(aside, moved, pulled),
        )

    def commands(
        self, positions: Float[np.ndarray, "motions 1 n 3"], motion: Moment
    ) -> Float[np.ndarray, "motions n 2"]:
        """Commands at some instants, by dynamics inversion.

        Args:
            positions: The undriven coordinates [m, rad, m].
            motion: Of lower carriage and height.

        Returns:
            The commands [V].
        """
        return self._command((), (positions, motion))[1][:, 0]

    def stretches(
        self, positions: Float[np.ndarray, "motions 1 n 3"], motion: Moment
    ) -> Float[np.ndarray, "motions n"]:
        """By how much the cables between drives and lower carriage give.

        Args:
            positions: The undriven coordinates [m, rad, m].
            motion: Of lower carriage and height.

        Returns:
            What the drives are to be ahead of the lower carriage [m].
        """
        return self._stretch((), (positions, motion))[1][:, 0]

    def commands_linearised(
        self,
        positions: Float[np.ndarray, "motions 1 n 3"],
        motion: Moment,
        *,
        along: tuple[Float[np.ndarray, "motions 1 splines n 3"], Moment],
    ) -> tuple[Float[np.ndarray, "motions n 2"], Float[np.ndarray, "motions n 2 splines"]]:
        """The same with derivatives.

        Args:
            positions: The undriven coordinates [m, rad, m].
            motion: Of lower carriage and height.
            along: Tangents of both.

        Returns:
            The commands [V] and their derivatives [V/m].
        """
        (_, volts), slopes = self._command.linearised(
            (), (positions, motion), along=Slopes((), along)
        )
        return volts[:, 0], slopes.rows[:, 0]


class Followers:
    """Robots as they might be under the feed-forward of another one."""

    def __init__(self, robots: Robot, servo: Servo):
        """Nothing runs yet.

        Args:
            robots: The robots, stacked.
            servo: The PD that is left with what they do otherwise.
        """
        self._robots, self._servo = _for_every_motion(robots), servo

    def steps(self, duration: float) -> native.Runs:
        """Steps of a length, for `follow`.

        Args:
            duration: The length [s].

        Returns:
            Runs of such steps.
        """
        own = _for_every_motion(Servo(*(part[None] for part in self._servo)))
        over = _for_every_motion(transitions(self._servo, duration))
        given = (self._robots, np.array([[duration]]), own, over)
        return native.Runs(deviating_step, given, teams=True)

    def follow(self, steps: native.Runs, start: Undriven, led: Led) -> Followed:
        """Robots led along a leg.

        Args:
            steps: See `steps`.
            start: Where each begins.
            led: Where each is led, a row for each step.

        Returns:
            What they do.
        """
        (end, aside), place = steps((start, _NONE), led)
        return Followed(end, aside, place)

    def follow_linearised(
        self,
        steps: native.Runs,
        start: Undriven,
        led: Led,
        *,
        along: tuple[
            Float[np.ndarray, "splines steps 3"],
            Float[np.ndarray, "motions 1 splines steps"],
        ],
        begun: Int[np.ndarray, " steps"],
    ) -> tuple[Followed, Followed]:
        """The same with derivatives by the coefficients of splines.

        Args:
            steps: See `steps`.
            start: Where each begins.
            led: Where each is led.
            along: What each spline does to the lead's lower carriage [1] and to the fitted
                robot's force [N/m].
            begun: How many of the splines have begun by the end of each step.

        Returns:
            What they do, and the derivatives.
        """
        still, calm = np.zeros((1, 1, 1, 3)), np.zeros((1, 1, 1))
        way, forces = along
        seeds = Slopes(
            (Undriven(still, still), Deviation(calm, calm)),
            Led(Lead(way[None, None], None), None, forces),
        )
        ((end, aside), place), slopes = steps.linearised(
            (start, _NONE), led, along=seeds, begun=begun
        )
        return Followed(end, aside, place), Followed(*slopes.carried, slopes.rows)


class Arriving:
    """Robots as their leg ends."""

    def __init__(self, robots: Robot):
        """Nothing runs yet.

        Args:
            robots: The robots, stacked.
        """
        every = _for_every_motion(robots)
        self._arrive = native.Runs(_arriving, every, teams=True)
        self._vibrate = native.Runs(_vibrating, every, teams=True)

    def __call__(self, run: Followed, goals: Goal) -> Arrival:
        """What robots do as their leg ends.

        Args:
            run: How they followed.
            goals: Where they are to be.

        Returns:
            What each does.
        """
        _, made = self._arrive((), _single_rows(run, goals))
        return Arrival(*(own[:, :, 0] for own in made))

    def linearised(
        self, run: Followed, goals: Goal, *, along: Followed
    ) -> tuple[Arrival, Arrival]:
        """The same with derivatives.

        Args:
            run: How they followed.
            goals: Where they are to be.
            along: Its derivatives.

        Returns:
            What each does, and its derivatives.
        """
        seeds = Undriven(*(np.moveaxis(own, -1, 2)[:, :, :, None] for own in along.end))
        lower = along.aside.position[..., None]
        (_, made), slopes = self._arrive.linearised(
            (),
            _single_rows(run, goals),
            along=Slopes((), (seeds, Goal(lower, None, None))),
        )
        values, derivatives = (
            Arrival(*(own[:, :, 0] for own in each)) for each in (made, slopes.rows)
        )
        return values, derivatives

    def vibrations(self, run: Followed, goals: Goal) -> Float[np.ndarray, "motions robots"]:
        """Largest peak to peak of the end-effectors once both carriages hold.

        Args:
            run: How they followed.
            goals: Where they are to be.

        Returns:
            Peak to peak [m].
        """
        return self._vibrate((), _single_rows(run, goals))[1][:, :, 0]


_NONE = Deviation(np.zeros((1, 1)), np.zeros((1, 1)))


def _for_every_motion(own: PyTree) -> PyTree:
    """Arrays that are behind an axis of robots."""
    return jax.tree.map(lambda leaf: np.asarray(leaf)[None], own)


_Row = tuple[Lead, Float[Array, "2"]]


def _advance(
    parameters: tuple[Robot, Array], state: Undriven, row: _Row
) -> tuple[Undriven, tuple[Float[Array, "3"], Float[Array, ""]]]:
    (robot, duration), (lead, velocity) = parameters, row
    position = whole_position(state.position, lead.lower[0], lead.height[0])
    force, _ = led_force(robot, position, velocity[0])
    return step(robot, state, lead, duration), (state.position, force)


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


def _arriving(robot: Robot, _: tuple, row: tuple[Undriven, Goal]) -> tuple[tuple, Arrival]:
    return (), arrival(robot, *row)


def _vibrating(robot: Robot, _: tuple, row: tuple[Undriven, Goal]) -> tuple[tuple, Array]:
    return (), vibration(robot, *row)


def _single_rows(run: Followed, goals: Goal) -> tuple[Undriven, Goal]:
    """States with where the carriages are in the end, each as a run of one step."""
    there = goals._replace(lower=goals.lower + run.aside.position)
    return (
        Undriven(*(own[:, :, None] for own in run.end)),
        Goal(*(own[:, :, None] for own in there)),
    )
