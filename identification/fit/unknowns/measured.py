r"""Numbers that were measured otherwise: weighed, on a data sheet, or by another sensor.

Each is one more residual of the fit, $(p(\theta) - v)/\sigma$, with the robot's own value $p$
of it: a quantity itself, a natural frequency, or the voltage at which the drives break the
carriage away. A quantity that was measured is free, so that its uncertainty reaches every
other one. A number that the campaign's own runs gave must not count a second time.
"""

import abc
import dataclasses
from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from identification.fit.unknowns.unknowns import PER_SETTING, apply
from scdpr_jax.linear.modes import BOTH_HELD, Condition, natural_frequencies
from scdpr_jax.robot.fields import real
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import quantity, value

APART = 3.0
"""Standard errors from which the logs contradict what was measured otherwise [1]."""


class Measured(eqx.Module):
    """A number that something other than the campaign's runs tells, with its error."""

    value: eqx.AbstractVar[Float[Array, ""]]
    """What was measured [SI]."""
    sigma: eqx.AbstractVar[Float[Array, ""]]
    """Its standard error [SI], above zero."""
    setting: eqx.AbstractVar[str | None]
    """Nominal pretension that it was measured at, as the logs name it, "350 N"."""

    @property
    @abc.abstractmethod
    def name(self) -> str:
        """What it is."""

    @property
    @abc.abstractmethod
    def unit(self) -> str:
        """Its SI unit."""

    @abc.abstractmethod
    def of(self, robot: Robot) -> Float[Array, ""]:
        """The robot's own value of it.

        Args:
            robot: The robot at that setting.

        Returns:
            The value [SI].
        """

    @property
    def frees(self) -> tuple[str, ...]:
        """Quantities that it leaves free, as it says how far they are known."""
        return ()

    def __check_init__(self) -> None:
        value, sigma = float(self.value), float(self.sigma)
        if not (np.isfinite(value) and np.isfinite(sigma) and sigma > 0):
            raise ValueError(
                f"the {self.name} must be a finite number with a standard error above zero "
                f"[{self.unit}], got {value:g} +- {sigma:g}. What is known exactly is given "
                "with the robot."
            )


class MeasuredQuantity(Measured):
    """One of the robot's named quantities."""

    quantity: str = eqx.field(static=True)
    """Its name, see `scdpr_jax.robot.quantities.QUANTITIES`."""
    value: Float[Array, ""] = eqx.field(converter=real)
    sigma: Float[Array, ""] = eqx.field(converter=real)
    setting: str | None = eqx.field(static=True, default=None)

    def __check_init__(self) -> None:
        if (self.quantity == PER_SETTING) != (self.setting is not None):
            raise ValueError(
                f"`setting` of {self.quantity!r}: got {self.setting!r}, expected "
                + ("the nominal pretension" if self.setting is None else "none")
                + f" [N]. Only `{PER_SETTING}` has a value for each setting."
            )

    @property
    def name(self) -> str:
        return self.quantity

    @property
    def unit(self) -> str:
        return quantity(self.quantity).unit

    def of(self, robot: Robot) -> Float[Array, ""]:
        return value(robot, self.quantity)

    @property
    def frees(self) -> tuple[str, ...]:
        return (self.quantity,)


class MeasuredFrequency(Measured):
    """A natural frequency of an aligned pose, Eq. (18)."""

    value: Float[Array, ""] = eqx.field(converter=real)
    sigma: Float[Array, ""] = eqx.field(converter=real)
    setting: str = eqx.field(static=True)
    height: Float[Array, ""] = eqx.field(converter=real)
    """Height of the end-effector [m]."""
    condition: Condition = BOTH_HELD
    """What held the carriages while it rang."""
    mode: int = eqx.field(static=True, default=0)
    """Which of the condition's modes it is, the lowest first."""
    unit = "Hz"

    def __check_init__(self) -> None:
        if not 0 <= self.mode < self.condition.modes:
            raise ValueError(
                f"`mode` must be from 0 to {self.condition.modes - 1} [1], got {self.mode}. "
                "The lowest mode is 0."
            )

    @property
    def name(self) -> str:
        return f"natural frequency at a height of {float(self.height):g} m"

    def of(self, robot: Robot) -> Float[Array, ""]:
        return natural_frequencies(robot, self.height, self.condition)[self.mode]


class MeasuredBreakaway(Measured):
    r"""The voltage, to both drives alike, at which the lower carriage starts from balance.

    $$ V = \frac{4 T \mu\, r + \tau_1 + \tau_2}{2 k_v} $$

    with the drives' dry frictions $\tau_1$ and $\tau_2$.
    """

    value: Float[Array, ""] = eqx.field(converter=real)
    sigma: Float[Array, ""] = eqx.field(converter=real)
    setting: str = eqx.field(static=True)

    name = "breakaway voltage"
    unit = "V"

    def of(self, robot: Robot) -> Float[Array, ""]:
        drive, cable = robot.drive, robot.cable
        friction = 4 * cable.effective_pretension * robot.lower_carriage.friction.coefficient
        torque = friction * drive.effective_radius + jnp.sum(drive.frictions)
        return torque / (2 * drive.torque_per_volt)


def require_settings(measured: Sequence[Measured], settings: Sequence[str]) -> None:
    """Refuse a number at a nominal pretension that no run has.

    Args:
        measured: What was measured otherwise.
        settings: The settings of the runs.

    Raises:
        ValueError: If there is one.
    """
    for number in measured:
        if number.setting is not None and number.setting not in settings:
            raise ValueError(
                f"the {number.name} was measured at {number.setting!r}, got runs at "
                f"{', '.join(sorted(settings)) or 'no setting'} only [N]. Log runs at that "
                "setting, or leave the number out."
            )


@eqx.filter_jit
def pulls(
    measured: tuple[Measured, ...],
    robot: Robot,
    free: tuple[str, ...],
    unknowns: Float[Array, "numbers n"],
) -> tuple[Float[Array, " numbers"], Float[Array, "numbers n"]]:
    """The robot's own numbers minus the measured ones over their errors, and the Jacobian.

    Args:
        measured: What was measured otherwise, one number at least.
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknowns: The free quantities as the fit holds them, at each number's setting.

    Returns:
        Residuals, and their derivatives by these quantities [1].
    """

    def pull(x: Float[Array, " n"], number: Measured) -> tuple[Array, Array]:
        residual = (number.of(apply(robot, free, x)) - number.value) / number.sigma
        return residual, residual

    both = [
        jax.jacfwd(pull, has_aux=True)(encoded, number)
        for encoded, number in zip(unknowns, measured, strict=True)
    ]
    slopes, residuals = zip(*both, strict=True)
    return jnp.stack(residuals), jnp.stack(slopes)


@dataclasses.dataclass(frozen=True)
class MeasuredFit:
    """A number that was measured otherwise, beside a robot's own."""

    measured: Measured
    """What was measured."""
    value: float
    """The robot's own value [SI]."""
    deviation: float
    """Own minus measured value, in the measurement's standard errors [1]."""

    @property
    def is_contradicted(self) -> bool:
        """Whether the logs contradict it."""
        return abs(self.deviation) >= APART

    @classmethod
    def of(cls, measured: Measured, robot: Robot) -> "MeasuredFit":
        """What was measured beside what a robot has.

        Args:
            measured: What was measured.
            robot: The robot at its setting.

        Returns:
            Both.
        """
        value = float(measured.of(robot))
        deviation = (value - float(measured.value)) / float(measured.sigma)
        return cls(measured, value, deviation)
