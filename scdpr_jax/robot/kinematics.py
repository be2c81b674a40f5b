"""Kinematics of the cable loop: rolls of the two driver pulleys and the end-effector."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

_SUM_AND_DIFFERENCE = np.array([[1.0, 1.0], [1.0, -1.0]])


def forward_kinematics(
    motor_angles: Float[Array | np.ndarray, "*rows 2"],
    pulley_radius: Float[Array | np.ndarray, ""],
) -> Float[Array | np.ndarray, "*rows 2"]:
    r"""Displacement of the end-effector for a roll of the driver pulleys, Eq. (2).

    $$ \Delta x_e = r (\Delta\alpha_1 + \Delta\alpha_2) / 2, \qquad
       \Delta y_e = r (\Delta\alpha_1 - \Delta\alpha_2) / 2 $$

    Linear, so that it turns angular velocities into velocities as well.

    Args:
        motor_angles: Roll $[\Delta\alpha_1, \Delta\alpha_2]$ of the pulleys [rad].
        pulley_radius: Effective radius $r$ of the driver pulleys [m].

    Returns:
        Displacement $[\Delta x_e, \Delta y_e]$ [m].
    """
    return pulley_radius / 2 * (motor_angles @ _SUM_AND_DIFFERENCE)


def inverse_kinematics(
    displacement: Float[Array, "2"], pulley_radius: Float[Array, ""]
) -> Float[Array, "2"]:
    r"""Roll of the driver pulleys for a displacement of the end-effector, Eq. (3).

    $$ \Delta\alpha_1 = (\Delta x_e + \Delta y_e) / r, \qquad
       \Delta\alpha_2 = (\Delta x_e - \Delta y_e) / r $$

    Printed with the two rolls exchanged, which doesn't invert Eq. (2) and sends the
    vertical experiments of Table 2 the wrong way: see `docs/errata.md`.

    Args:
        displacement: Displacement $[\Delta x_e, \Delta y_e]$ [m].
        pulley_radius: Effective radius $r$ of the driver pulleys [m].

    Returns:
        Roll $[\Delta\alpha_1, \Delta\alpha_2]$ of the pulleys [rad].
    """
    horizontal, vertical = displacement
    return jnp.stack([horizontal + vertical, horizontal - vertical]) / pulley_radius
