r"""The loop's own elasticity: Table 1's cable, its stiffness and what a longer path costs.

The model's loop has constant tension, as if a soft tensioner held it. A loop of bare cable
doesn't: its length is fixed, so that a longer path stretches it, with the axial stiffness
$EA$ over the loop's length.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.robot.cable import paths
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.parameters import Robot


class CableSection(eqx.Module):
    """The cable's material and section."""

    modulus: Float[Array, "..."] = eqx.field(converter=real, metadata=si("Pa", "E"))
    """Young's modulus $E$ [Pa]."""
    diameter: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "d"))
    """Diameter $d$ of the section, taken as solid [m]."""

    @property
    def axial_stiffness(self) -> Float[Array, "..."]:
        r"""Force per strain, $EA = E \pi d^2 / 4$ [N]."""
        return self.modulus * jnp.pi * jnp.square(self.diameter) / 4


def consistent_section() -> CableSection:
    """Table 1's cable with steel's modulus.

    Returns:
        2 mm of diameter, 209.12 GPa.
    """
    return CableSection(modulus=209.12e9, diameter=2e-3)


def published_section() -> CableSection:
    """Table 1's cable as printed: a hundredth of steel's modulus, see `docs/errata.md`.

    Returns:
        2 mm of diameter, 2.0912 GPa.
    """
    return CableSection(modulus=2.0912e9, diameter=2e-3)


def moving_length(robot: Robot, position: Float[Array, "5"]) -> Float[Array, ""]:
    r"""Length of the loop's moving parts, $2(\ell_\alpha + \ell_\beta + \ell_\gamma)$.

    Two parallel cables on each of the three paths of Eq. (4). Its gradient times the tension
    is the loop's force, Eqs. (7), (8) and (16).

    Args:
        robot: The robot.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].

    Returns:
        Length [m].
    """
    return 2 * sum(path.length for path in paths(robot, position))


def loop_length(robot: Robot) -> Float[Array, ""]:
    r"""Length of the whole loop at an aligned pose, which is the same at every height.

    $$ L = 2(2H - a - b) + 2W $$

    The moving parts, and the stretches along both guides, each as long as the frame is wide.

    Args:
        robot: The robot.

    Returns:
        Length [m]; 8.3 with Table 1.
    """
    body, frame = robot.end_effector, robot.frame
    vertical = 2 * frame.height - body.lower_offset - body.upper_offset
    return 2 * vertical + 2 * frame.width


def lengthening(robot: Robot, position: Float[Array, "5"]) -> Float[Array, ""]:
    r"""By how much the loop's path is longer than at an aligned pose.

    $$ \Delta L(q) = 2(\ell_\alpha + \ell_\beta + \ell_\gamma) - 2(2H - a - b) \ge 0 $$

    Second order in how far the robot is out of line, so that it leaves the linear model of
    an aligned pose as it is.

    Args:
        robot: The robot.
        position: Coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].

    Returns:
        Lengthening [m].
    """
    body, frame = robot.end_effector, robot.frame
    aligned = 2 * (2 * frame.height - body.lower_offset - body.upper_offset)
    return moving_length(robot, position) - aligned


def loop_stiffness(robot: Robot, section: CableSection) -> Float[Array, ""]:
    r"""Rise of a bare loop's tension per lengthening, $k_L = EA / L$.

    Args:
        robot: The robot.
        section: Its cable.

    Returns:
        Stiffness [N/m]; 79 kN/m with Table 1 and steel.
    """
    return section.axial_stiffness / loop_length(robot)
