"""What a log says about a motor-driven axis."""

import dataclasses

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from identification.axis.motion import AxisParameters
from identification.sensitivity.combinations import Combination
from scdpr_jax.robot.fields import real, si

PARAMETER_NAMES = ("mass", "viscous", "coulomb", "offset")
"""The usual law's parameters, in the order of every vector and matrix here."""

LINEAR_UNITS = {
    "mass": "kg",
    "viscous": "N s/m",
    "coulomb": "N",
    "offset": "N",
    "viscous_difference": "N s/m",
}
"""SI units of a linear axis's parameters."""

ROTARY_UNITS = {
    "mass": "kg m^2",
    "viscous": "N m s",
    "coulomb": "N m",
    "offset": "N m",
    "viscous_difference": "N m s",
}
"""SI units of a rotary axis's parameters."""

EXTENDED_NAMES = (*PARAMETER_NAMES, "viscous_difference")
"""Those of the law in which viscous friction differs with the direction."""

DOES_NOT_FIT = "model_does_not_fit"
"""Status of every parameter of a law that doesn't fit."""


@dataclasses.dataclass(frozen=True)
class Change:
    """A parameter that the halves of a record don't agree about."""

    name: str
    """The parameter."""
    first: float
    """Its value by the first half [SI]."""
    second: float
    """Its value by the second half [SI]."""


class DriveAxisEstimate(eqx.Module):
    """Parameters of an axis with their uncertainty, and how well they predict its log."""

    parameters: AxisParameters
    """Values [kg, N s/m, N, N]."""
    sigma: AxisParameters
    """Standard errors, robust to correlated residuals and to what the law lacks [kg, N s/m,
    N, N]; infinite for what the log doesn't tell."""
    interval95: Float[Array, "parameters 2"]
    """95 % intervals, one row for each of `names`."""
    correlation: Float[Array, "parameters parameters"]
    """Correlation of the estimates [1]."""
    status: tuple[str, ...] = eqx.field(static=True)
    """`identified`, `weak`, `unidentifiable`, `at_bound` or `model_does_not_fit`, one for each
    parameter."""
    open_loop_rmse: Float[Array, ""] = eqx.field(converter=real, metadata=si("m"))
    """Root mean square of simulated minus measured position [m]."""
    positions: Float[Array, " samples"] = eqx.field(converter=real, metadata=si("m"))
    """Simulated positions, each piece of the record open loop [m]."""
    memory: Float[Array, ""] = eqx.field(converter=real, metadata=si("s"))
    """Time over which the residuals were taken to hang together [s]."""
    starts: int = eqx.field(static=True)
    """Starts of the search."""
    agreeing_starts: int = eqx.field(static=True)
    """Starts that came within some 10 % of the best error, before the polish."""
    iterations: int = eqx.field(static=True)
    """Steps of the search, those along the gradient and those of the polish."""
    converged: bool = eqx.field(static=True)
    """Whether no step in any direction was left that lowers the error noticeably."""
    names: tuple[str, ...] = eqx.field(static=True, default=PARAMETER_NAMES)
    """What was estimated: `PARAMETER_NAMES` or `EXTENDED_NAMES`."""
    combinations: tuple[Combination, ...] = eqx.field(static=True, default=())
    """Combinations of the parameters, from the best to the worst told."""
    changes: tuple[Change, ...] = eqx.field(static=True, default=())
    """Parameters that the record's halves don't agree about: one law doesn't fit it."""
    horizons: tuple[float, ...] = eqx.field(static=True, default=())
    """Lengths of the predictions that were fitted beside the open loop [s]."""
    sum_sigma: Float[Array, ""] = eqx.field(converter=real, default=jnp.nan)
    """Standard error of Coulomb friction and offset together, where the log tells no more [N
    or N m]."""
    notes: tuple[str, ...] = eqx.field(static=True, default=())
    """What is remarkable about the log, a sentence each."""
    position_unit: str = eqx.field(static=True, default="m")
    """SI unit of its positions: "m", or "rad" of a rotary axis."""

    @property
    def units(self) -> dict[str, str]:
        """SI units of the parameters."""
        return LINEAR_UNITS if self.position_unit == "m" else ROTARY_UNITS

    @property
    def untold(self) -> tuple[Combination, ...]:
        """Combinations that the log doesn't tell, however small its noise."""
        return tuple(each for each in self.combinations if not each.is_told)

    def sum_of_frictions(self) -> tuple[float, float] | None:
        """Coulomb friction and offset together, where the log tells their sum alone.

        Returns:
            The sum, or the difference of an axis that only moves backwards, with its standard
            error [N or N m]; None where the log tells each, or neither.
        """
        at = [self.names.index(name) for name in ("coulomb", "offset")]
        for each in self.untold:
            parts = np.array(each.powers)
            friction, offset = parts[at]
            if np.hypot(friction, offset) > 0.99 and abs(abs(friction) - abs(offset)) < 0.1:
                sign = -np.sign(friction * offset)
                values = [float(getattr(self.parameters, self.names[k])) for k in at]
                return values[0] + sign * values[1], float(self.sum_sigma)
        return None

    @property
    def fits(self) -> bool:
        """Whether the law explains the motion, as far as a law can."""
        return DOES_NOT_FIT not in self.status
