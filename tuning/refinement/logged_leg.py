"""A leg as it was logged, on the even steps that it is replayed on."""

import dataclasses
import functools

import numpy as np
from jaxtyping import Float

from scdpr_jax.engines.led_stepping import Lead, thirds
from scdpr_jax.robot.fields import si

STEP = 4e-3
"""Length of a step [s]: a hundredth of the shortest period that a camera shows."""
SMOOTH, SMOOTHER = 30e-3, 60e-3
"""Windows of velocities and of accelerations [s]: encoders count."""
CREEP = 2e-3
"""Velocity below which the lower carriage counts as at rest [m/s]: a count in a window."""


@dataclasses.dataclass(frozen=True, eq=False)
class LoggedLeg:
    """A leg, planned or not, as drives and camera saw it."""

    name: str
    """What it is called."""
    time: Float[np.ndarray, " rows"] = dataclasses.field(metadata=si("s"))
    """Times of the drives' rows [s]."""
    angle: Float[np.ndarray, "rows 2"] = dataclasses.field(metadata=si("rad"))
    """Angles of the driver pulleys, from any zero [rad]."""
    voltage: Float[np.ndarray, "rows 2"] = dataclasses.field(metadata=si("V"))
    """Commands, each held until the next row [V]."""
    seen_time: Float[np.ndarray, " frames"] = dataclasses.field(metadata=si("s"))
    """Times of the camera's frames on the drives' clock [s]."""
    seen: Float[np.ndarray, "frames 3"] = dataclasses.field(metadata=si("m, rad, m"))
    r"""What they show, $[x_e, \delta_e, q_4]$ [m, rad, m]; NaN where nothing was seen."""
    place: tuple[float, float] = dataclasses.field(metadata=si("m"))
    """Where the end-effector rested before it, between the carriages [m]."""
    slope: float = dataclasses.field(metadata=si("1"))
    """Slope of the line between the carriages there [1]."""
    noise: tuple[float, float] = dataclasses.field(metadata=si("m, rad"))
    """Standard deviations of the camera's places and of its rotations [m, rad]."""

    @property
    def steps(self) -> int:
        """Steps that it is replayed in."""
        return int((self.time[-1] - self.time[0]) / STEP)

    @functools.cached_property
    def begins(self) -> Float[np.ndarray, " steps"]:
        """Times at which they begin [s]."""
        return self.time[0] + STEP * np.arange(self.steps)

    def way(self, radius: float) -> Float[np.ndarray, "halves 2"]:
        """How far the drives have led lower carriage and height, at every half step.

        Args:
            radius: Effective radius of the driver pulleys [m].

        Returns:
            From the begin [m].
        """
        halves = self.time[0] + STEP / 2 * np.arange(2 * self.steps + 1)
        turned = np.stack(
            [np.interp(halves, self.time, own - own[0]) for own in self.angle.T], axis=1
        )
        first, second = radius * turned.T / 2
        return np.stack([first + second, first - second], axis=1)

    @functools.cached_property
    def commanded(self) -> Float[np.ndarray, "steps 2"]:
        """Means of the commands in the steps [V]."""
        spent = np.cumsum(self.voltage[:-1] * np.diff(self.time)[:, None], axis=0)
        spent = np.concatenate([np.zeros((1, 2)), spent])
        edges = np.append(self.begins, self.begins[-1] + STEP)
        at = np.stack([np.interp(edges, self.time, own) for own in spent.T], axis=1)
        return np.diff(at, axis=0) / STEP


@dataclasses.dataclass(frozen=True, eq=False)
class Way:
    """Where the drives led a leg, step by step, from where it began."""

    lead: Lead
    """Lower carriage and height, behind an axis of robots [m]."""
    velocity: Float[np.ndarray, "1 steps 2"] = dataclasses.field(metadata=si("m/s"))
    """Their velocities as the steps begin [m/s]."""
    acceleration: Float[np.ndarray, "1 steps 2"] = dataclasses.field(metadata=si("m/s^2"))
    """Their accelerations [m/s²]."""

    @classmethod
    def of(cls, leg: LoggedLeg, radius: float) -> "Way":
        """The way of a leg.

        Args:
            leg: The leg.
            radius: Effective radius of the driver pulleys [m].

        Returns:
            The way.
        """
        halves = leg.way(radius)
        velocity, acceleration = (
            _derivative(halves, order, window)[:-1:2]
            for order, window in ((1, SMOOTH), (2, SMOOTHER))
        )
        velocity = np.where(np.abs(velocity) < CREEP, 0.0, velocity)
        return cls(
            Lead(*(thirds(own)[None] for own in halves.T)),
            velocity[None],
            acceleration[None],
        )


def _derivative(
    halves: Float[np.ndarray, "halves 2"], order: int, window: float
) -> Float[np.ndarray, "halves 2"]:
    """A derivative of cubics through windows."""
    # It brings `scipy.stats`, which takes as long to load as all else of a plan.
    from scipy.signal import savgol_filter

    count = 2 * round(window / STEP) + 1
    return savgol_filter(halves, count, 3, deriv=order, delta=STEP / 2, axis=0)
