r"""The drive: servo-amplifier, motor, gearbox and driver pulley, Eq. (24), section 5.1."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float

from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.parameters import Drive


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


def motor_current(drive: Drive, voltage: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
    r"""Current of a motor for a command, which the servo-amplifier holds, section 5.1.

    $$ I = k_v \,\mathrm{sat}(V) / k_i $$

    The nameplates give 0.6 A/V, 6 A at the limit; the gain of Eq. (24) asks for 0.614 A/V.

    Args:
        drive: The drive.
        voltage: Command to the servo-amplifier [V]; beyond the limit it saturates.

    Returns:
        Motor current [A].
    """
    return motor_torque(drive, voltage) / drive.torque_per_ampere


def drive_gain(drive: Drive) -> Float[Array | np.ndarray, "..."]:
    r"""Angular acceleration per volt, $g = k_v / J$, the numerator of Eq. (24).

    Printed as $1/J$, with the angle in degrees: see `docs/errata.md`.

    Args:
        drive: The drive.

    Returns:
        Gain [rad/s²/V].
    """
    return drive.torque_per_volt / drive.inertia


def drive_pole(drive: Drive) -> Float[Array | np.ndarray, "..."]:
    r"""Viscous pole of a bare drive, $p = b / J$, Eq. (24).

    Args:
        drive: The drive; its dry friction has no part in it.

    Returns:
        Pole [1/s].
    """
    return drive.damping / drive.inertia


class TransferFunction(eqx.Module):
    r"""Command to pulley angle of a bare drive, $G(s) = g / (s (s + p))$, Eq. (24)."""

    gain: Float[Array, "..."] = eqx.field(converter=real, metadata=si("rad/s^2/V", "g"))
    """Angular acceleration per volt $g = k_v / J$ [rad/s²/V]."""
    pole: Float[Array, "..."] = eqx.field(converter=real, metadata=si("1/s", "p"))
    """Viscous pole $p = b / J$ [1/s]; the same in degrees."""

    @property
    def gain_in_degrees(self) -> Float[Array, "..."]:
        """The gain with the angle in degrees, as Eq. (24) prints it [deg/s²/V]."""
        return jnp.rad2deg(self.gain)

    def response(self, angular_frequency: Float[Array, "*shape"]) -> Complex[Array, "*shape"]:
        r"""Frequency response.

        $$ G(j\omega) = -\frac{g}{\omega^2 + p^2} \left(1 + j\,\frac{p}{\omega}\right) $$

        Args:
            angular_frequency: $\omega$ [rad/s], not zero.

        Returns:
            Response [rad/V].
        """
        in_phase = -self.gain / (jnp.square(angular_frequency) + jnp.square(self.pole))
        return jax.lax.complex(in_phase, in_phase * self.pole / angular_frequency)


def transfer_function(drive: Drive) -> TransferFunction:
    """Transfer function of a drive with its pulley, the cable off, Eq. (24).

    Args:
        drive: The drive.

    Returns:
        Its transfer function, in radians.
    """
    return TransferFunction(gain=drive_gain(drive), pole=drive_pole(drive))
