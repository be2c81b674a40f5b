"""What belongs to one run alone: its start, its knock, and its camera's clock.

These numbers are estimated together with the robot: a start is seen only as well as the camera
sees it, nobody measures a knock, and two clocks are never quite together. What is known of them
before enters as so many measurements. The fields of `Circumstances` are the one table of them:
every vector, prior and mask of a fit has their order.
"""

import dataclasses

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from identification.campaign.types import Run
from identification.data.start import USUAL_ARM, USUAL_DRIFT, Clock, Start
from scdpr_jax.robot.fields import real, si


class Beginning(eqx.Module):
    """How a run begins that doesn't begin at rest.

    The end-effector's place is told from where it would rest between the carriages, so that a
    run at rest has zeros. The lower carriage and the height go with the drives.
    """

    aside: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "x_e(0)"))
    """Start of the end-effector, less where it would rest [m]."""
    tilt: Float[Array, "..."] = eqx.field(converter=real, metadata=si("rad", r"\delta_e(0)"))
    """Its rotation, less that at rest [rad]."""
    speed: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m/s", r"\dot x_e(0)"))
    """Velocity of the end-effector [m/s]."""
    turning: Float[Array, "..."] = eqx.field(
        converter=real, metadata=si("rad/s", r"\dot\delta_e(0)")
    )
    """Its angular velocity [rad/s]."""
    upper_speed: Float[Array, "..."] = eqx.field(
        converter=real, metadata=si("m/s", r"\dot q_4(0)")
    )
    """Velocity of the upper carriage [m/s]."""
    drive_1_speed: Float[Array, "..."] = eqx.field(
        converter=real, metadata=si("rad/s", r"\dot\alpha_1(0)")
    )
    """Angular velocity of the first drive's pulley [rad/s]."""
    drive_2_speed: Float[Array, "..."] = eqx.field(
        converter=real, metadata=si("rad/s", r"\dot\alpha_2(0)")
    )
    """Angular velocity of the second drive's pulley [rad/s]."""

    @property
    def vector(self) -> Float[Array, " beginning"]:
        """One number for each, in the order of the fields."""
        return jnp.stack([getattr(self, name) for name in BEGINNING])


BEGINNING = tuple(field.name for field in dataclasses.fields(Beginning))
"""Names of what a run in motion begins with, in their order."""

TURNING_DRIVES = ("drive_1_speed", "drive_2_speed")
"""Those of them that bare drives have."""


class Circumstances(eqx.Module):
    """What belongs to one run alone and is estimated with the robot's parameters."""

    lower: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "q_3(0)"))
    """Start of the lower carriage [m]."""
    upper: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "q_4(0)"))
    """Start of the upper carriage [m]."""
    height: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "y_e(0)"))
    """Start of the end-effector's height [m]."""
    knock: Float[Array, "..."] = eqx.field(converter=real, metadata=si("N", "F"))
    """Force of the knock while it lasts [N]."""
    knock_arm: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "h"))
    """Height above the centre of mass at which it acts [m]."""
    clock_offset: Float[Array, "..."] = eqx.field(converter=real, metadata=si("s"))
    """Camera time minus drive time at the run's first row, beyond what the log says [s]."""
    clock_drift: Float[Array, "..."] = eqx.field(converter=real, metadata=si("1"))
    """By how much the camera's clock runs faster than the drives' [1]."""
    beginning: Beginning | None = None
    """How the run begins, None where no run of its campaign begins in motion."""

    @classmethod
    def of(cls, vector: Float[Array | np.ndarray, " circumstances"]) -> "Circumstances":
        """The circumstances that a vector of them stands for.

        Args:
            vector: One number for each, in the order of `NAMES`, then of `BEGINNING` where
                a run of the campaign begins in motion.

        Returns:
            The circumstances.
        """
        numbers = [*vector]
        beginning = Beginning(*numbers[len(NAMES) :]) if len(numbers) > len(NAMES) else None
        return cls(*numbers[: len(NAMES)], beginning=beginning)

    @property
    def vector(self) -> Float[Array, " circumstances"]:
        """One number for each, in the order of `NAMES`, then of `BEGINNING`."""
        usual = jnp.stack([getattr(self, name) for name in NAMES])
        return usual if self.beginning is None else jnp.append(usual, self.beginning.vector)


NAMES = tuple(
    field.name for field in dataclasses.fields(Circumstances) if field.name != "beginning"
)
"""Names of the circumstances of any run, in their order."""


def _part(first: str, last: str) -> slice:
    return slice(NAMES.index(first), NAMES.index(last) + 1)


START = _part("lower", "height")
"""Where the start's three coordinates stand."""

MOVING = _part("lower", "knock_arm")
"""Where what moves the robot stands: the start and the knock."""

CLOCK = _part("clock_offset", "clock_drift")
"""Where the camera's clock stands, which moves no robot."""


def names_of(*, in_motion: bool) -> tuple[str, ...]:
    """Names of the circumstances of a campaign's runs, in the order of their vectors.

    Args:
        in_motion: Whether any of the runs begins in motion.

    Returns:
        `NAMES`, and `BEGINNING` at need: every number costs each Jacobian a simulation.
    """
    return (*NAMES, *BEGINNING) if in_motion else NAMES


def open_circumstances(
    run: Run, *, clock_drifts: bool, in_motion: bool = False
) -> Bool[np.ndarray, " circumstances"]:
    """Which of its circumstances a run leaves open.

    Args:
        run: The run.
        clock_drifts: Whether the cameras' clocks may drift.
        in_motion: Whether any run of the campaign begins in motion.

    Returns:
        True for each one to estimate; a run of the bare drives has none, or what they begin
        with.
    """
    cabled = run.kind != "motor_step"
    knocked = cabled and run.knock is not None
    seen = cabled and run.camera is not None
    is_open = {
        "lower": cabled,
        "upper": cabled,
        "height": cabled,
        "knock": knocked,
        "knock_arm": knocked,
        "clock_offset": seen and run.clock_offset is None,
        "clock_drift": seen and clock_drifts,
    }
    begun = BEGINNING if cabled else TURNING_DRIVES
    is_open |= {name: run.in_motion and name in begun for name in BEGINNING}
    return np.array([is_open[name] for name in names_of(in_motion=in_motion)])


class Prior(eqx.Module):
    """What is known of a run's circumstances before any fit, as measurements of them."""

    mean: Float[Array, "... circumstances"] = eqx.field(converter=real)
    """What they are expected to be [SI]."""
    weight: Float[Array, "... circumstances"] = eqx.field(converter=real)
    """Inverse standard deviations [1/SI]; 0 for what is unknown, and for what is known
    exactly, which no fit leaves open."""

    def residuals(self, circumstances: Circumstances) -> Float[Array, " circumstances"]:
        """Expectation minus circumstances over the standard deviations.

        Args:
            circumstances: The circumstances.

        Returns:
            Residuals; zero where nothing is known before [1].
        """
        return self.weight * (self.mean - circumstances.vector)


def prior(
    run: Run, start: Start, clock: Clock, *, clock_drifts: bool, in_motion: bool = False
) -> Prior:
    """What is known of a run's circumstances before any fit.

    Args:
        run: A run with the cable on.
        start: What is known of where it starts.
        clock: What is known of its camera's clock, which the stamps were put right by.
        clock_drifts: Whether the cameras' clocks may drift.
        in_motion: Whether any run of the campaign begins in motion.

    Returns:
        Expectations and their inverse standard deviations.
    """
    drift = USUAL_DRIFT if clock_drifts else 0.0
    length = run.drive.time[-1] - run.drive.time[0]
    # What was known of the offset was its mean over the run.
    offset_sigma = np.hypot(clock.sigma, drift * length / 2)
    names = names_of(in_motion=in_motion)
    mean, weight = (dict.fromkeys(names, 0.0) for _ in range(2))
    mean |= zip(NAMES[START], start.position, strict=True)
    weight |= zip(NAMES[START], 1 / start.sigma, strict=True)
    if start.beginning is not None:
        mean |= zip(BEGINNING, start.beginning.value, strict=True)
        weight |= zip(BEGINNING, 1 / start.beginning.sigma, strict=True)
    if run.knock is not None:
        weight["knock_arm"] = 1 / USUAL_ARM
    if clock.sigma > 0:
        weight["clock_offset"] = 1 / offset_sigma
    if drift > 0:
        weight["clock_drift"] = 1 / drift
    return Prior(np.array([*mean.values()]), np.array([*weight.values()]))
