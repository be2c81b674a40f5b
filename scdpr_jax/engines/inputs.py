"""What acts on the robot on a time grid, checked where it is known."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.engines.arguments import check_finite, check_shape, possible_duration
from scdpr_jax.robot.fields import real, si


class Inputs(eqx.Module):
    """What acts on the robot in the intervals of a time grid, held through each."""

    duration: Float[Array, "..."] = eqx.field(converter=real, metadata=si("s", "h"))
    """Lengths of the intervals [s]; one of length 0 leaves the state as it is."""
    voltage: Float[Array, "... 2"] = eqx.field(converter=real, metadata=si("V", "V"))
    """Commands to the two drives [V]."""
    knock: Float[Array, "..."] = eqx.field(converter=real, metadata=si("N", "F"))
    """Horizontal force on the end-effector [N]."""

    def __check_init__(self):
        rows = jnp.shape(self.voltage)[:-1]
        check_shape(self.voltage, (*rows, 2), name="voltage", unit="V")
        for name, unit in (("duration", "s"), ("knock", "N")):
            lengths = jnp.shape(getattr(self, name))
            # One number stands for all intervals.
            if lengths:
                check_shape(getattr(self, name), rows, name=name, unit=unit)
        possible_duration(self.duration)
        check_finite(self.voltage, name="voltage", unit="V")
        check_finite(self.knock, name="knock", unit="N")


def possible_inputs(inputs: Inputs) -> Inputs:
    """Inputs of a time grid, a row for each interval.

    Args:
        inputs: The inputs.

    Returns:
        The inputs; durations are NaN where they are traced and one is negative.

    Raises:
        ValueError: If a shape is another, a duration is negative, or a number isn't finite.
    """
    rows = jnp.shape(inputs.duration)[:1]
    check_shape(inputs.duration, ("n",), name="duration", unit="s")
    check_shape(inputs.voltage, (*rows, 2), name="voltage", unit="V")
    check_shape(inputs.knock, rows, name="knock", unit="N")
    check_finite(inputs.voltage, name="voltage", unit="V")
    check_finite(inputs.knock, name="knock", unit="N")
    return Inputs(possible_duration(inputs.duration), inputs.voltage, inputs.knock)
