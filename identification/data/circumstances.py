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

    @classmethod
    def of(cls, vector: Float[Array | np.ndarray, " circumstances"]) -> "Circumstances":
        """The circumstances that a vector of them stands for.

        Args:
            vector: One number for each, in the order of the fields.

        Returns:
            The circumstances.
        """
        return cls(*vector)

    @property
    def vector(self) -> Float[Array, " circumstances"]:
        """One number for each, in the order of the fields."""
        return jnp.stack([getattr(self, name) for name in NAMES])


NAMES = tuple(field.name for field in dataclasses.fields(Circumstances))
"""Names of the circumstances, in their order."""


def _part(first: str, last: str) -> slice:
    return slice(NAMES.index(first), NAMES.index(last) + 1)


START = _part("lower", "height")
"""Where the start's three coordinates stand."""

MOVING = _part("lower", "knock_arm")
"""Where what moves the robot stands: the start and the knock."""

CLOCK = _part("clock_offset", "clock_drift")
"""Where the camera's clock stands, which moves no robot."""


def open_circumstances(run: Run, *, clock_drifts: bool) -> Bool[np.ndarray, " circumstances"]:
    """Which of its circumstances a run leaves open.

    Args:
        run: The run.
        clock_drifts: Whether the cameras' clocks may drift.

    Returns:
        True for each one to estimate; a run of the bare drives has none.
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
    return np.array([is_open[name] for name in NAMES])


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


def prior(run: Run, start: Start, clock: Clock, *, clock_drifts: bool) -> Prior:
    """What is known of a run's circumstances before any fit.

    Args:
        run: A run with the cable on.
        start: What is known of where it starts.
        clock: What is known of its camera's clock, which the stamps were put right by.
        clock_drifts: Whether the cameras' clocks may drift.

    Returns:
        Expectations and their inverse standard deviations.
    """
    drift = USUAL_DRIFT if clock_drifts else 0.0
    length = run.drive.time[-1] - run.drive.time[0]
    # What was known of the offset was its mean over the run.
    offset_sigma = np.hypot(clock.sigma, drift * length / 2)
    mean, weight = (dict.fromkeys(NAMES, 0.0) for _ in range(2))
    mean |= zip(NAMES[START], start.position, strict=True)
    weight |= zip(NAMES[START], 1 / start.sigma, strict=True)
    if run.knock is not None:
        weight["knock_arm"] = 1 / USUAL_ARM
    if clock.sigma > 0:
        weight["clock_offset"] = 1 / offset_sigma
    if drift > 0:
        weight["clock_drift"] = 1 / drift
    return Prior(np.array([*mean.values()]), np.array([*weight.values()]))
