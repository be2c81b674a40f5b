r"""The drive: servo-amplifier, motor, gearbox and driver pulley, Eq. (24), section 5.1."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.parameters import Drive


def motor_torque(drive: Drive, voltage: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
    r"""Torque of a motor at the output shaft, before friction and damping, section 5.1.

    $$ \tau = k_v \,\mathrm{sat}(V) $$

    Args:
        drive: The drive.
        voltage: Command to the servo-amplifier [V]; beyond the limit it saturates.

    Returns:
        Torque [N m].
    """
    limited = jnp.clip(voltage, -drive.voltage_limit, drive.voltage_limit)
    return drive.torque_per_volt * limited
