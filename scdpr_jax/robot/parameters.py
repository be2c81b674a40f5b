"""The robot's parameters: frozen pytrees, every number an array leaf with its unit.

`scdpr_jax.robot.quantities` has their names in files and tables.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.robot.fields import described, measured, real, si
from scdpr_jax.robot.friction import Coulomb, Friction, SmoothCoulomb


class Frame(eqx.Module):
    """The rectangular frame; the origin is its lower left corner."""

    width: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "W"))
    """Width $W$ [m]."""
    height: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "H"))
    """Height $H$ between the two guides [m]."""


class EndEffector(eqx.Module):
    """The end-effector, a rigid body hung between the lower and the upper cables."""

    mass: Float[Array, "..."] = eqx.field(converter=real, metadata=si("kg", "m_e"))
    """Mass $m_e$ [kg]."""
    inertia: Float[Array, "..."] = eqx.field(converter=real, metadata=si("kg m^2", "I_e"))
    """Moment of inertia $I_e$ about the centre of mass [kg m²]."""
    lower_offset: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "a"))
    """Distance $a$ of the lower cables' attachment below the centre of mass [m]."""
    upper_offset: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "b"))
    """Distance $b$ of the upper cables' attachment above the centre of mass [m]."""
    knock_arm: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("m", "h")
    )
    """Height $h$ above the centre of mass at which it is knocked [m]."""


class Carriage(eqx.Module):
    """A passive carriage sliding on a horizontal guide of the frame."""

    mass: Float[Array, "..."] = eqx.field(converter=real, metadata=si("kg", "m_3, m_4"))
    """Mass of the carriage with its pulleys [kg]."""
    width: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "w_3, w_4"))
    """Width along the guide [m]."""
    friction: Friction
    """Friction on the guide."""


class Cable(eqx.Module):
    """The single cable loop, inextensible; of constant tension unless it has a stiffness."""

    effective_pretension: Float[Array, "..."] = eqx.field(converter=real, metadata=si("N", "T"))
    """Effective pretension $T$ [N]: what the model needs, not the tensioner's setting."""
    stiffness: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("N/m", "k")
    )
    """Rise of the tension per lengthening of the loop's path [N/m]: the tensioner's."""


class Drive(eqx.Module):
    """One of the two equal drives: servo-amplifier, motor, gearbox and driver pulley."""

    effective_radius: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m", "r"))
    """Effective radius $r$ of the driver pulley [m]."""
    inertia: Float[Array, "..."] = eqx.field(converter=real, metadata=si("kg m^2", "J"))
    """Rotational inertia $J$ at the output shaft [kg m²]."""
    damping: Float[Array, "..."] = eqx.field(converter=real, metadata=si("N m s", "b"))
    """Viscous damping $b$ at the output shaft [N m s]."""
    friction: Float[Array, "..."] = eqx.field(converter=real, metadata=si("N m", r"\tau_f"))
    r"""Dry friction torque $\tau_f$ at the output shaft [N m]."""
    friction_width: Float[Array, "..."] = eqx.field(
        converter=real, metadata=si("rad/s", r"\omega_s")
    )
    r"""Angular velocity $\omega_s$ over which the dry friction turns round [rad/s] where it is
    smoothed, in `scdpr_jax.engines.adaptive`; it is exact in `scdpr_jax.engines.stepping`."""
    torque_per_volt: Float[Array, "..."] = eqx.field(
        converter=real, metadata=si("N m/V", "k_v")
    )
    """Torque at the output shaft per volt of command $k_v$ [N m/V]."""
    torque_per_ampere: Float[Array, "..."] = eqx.field(
        converter=real, metadata=si("N m/A", "k_i")
    )
    """Torque at the output shaft per ampere of motor current [N m/A]."""
    voltage_limit: Float[Array, "..."] = eqx.field(converter=real, metadata=si("V", r"V_{max}"))
    """Largest command of either sign [V]."""
    friction_difference: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("N m", r"\Delta\tau_f")
    )
    r"""Dry friction torque of the second drive minus that of the first [N m]."""

    compliance: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("m/N", "c")
    )
    """By how much the cables between drives and lower carriage give per force on it [m/N];
    what leads the drives allows for it, the engines take them for rigid."""

    @property
    def frictions(self) -> Float[Array, "2"]:
        """Dry friction torques of the two drives [N m]."""
        half = self.friction_difference / 2
        return jnp.stack([self.friction - half, self.friction + half])


class Robot(eqx.Module):
    """The planar cable robot with a single cable loop and two passive carriages."""

    frame: Frame
    end_effector: EndEffector
    lower_carriage: Carriage
    upper_carriage: Carriage
    cable: Cable
    drive: Drive
    gravity: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("m/s^2", "g")
    )
    """Gravitational acceleration [m/s²]; the paper leaves it out (0)."""

    @property
    def heights(self) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
        """Lowest and highest place of the end-effector, its attachments at the guides [m]."""
        body = self.end_effector
        return body.lower_offset, self.frame.height - body.upper_offset

    def __repr__(self) -> str:
        """A line for each part, with units."""
        parts = ("frame", "end_effector", "lower_carriage", "upper_carriage", "cable", "drive")
        lines = [f"  {part}: {described(getattr(self, part))}" for part in parts]
        return "\n".join(["Robot", *lines, f"  gravity: {measured(self.gravity, 'm/s^2')}"])


def with_friction(robot: Robot, *, lower: Friction, upper: Friction) -> Robot:
    """The robot with other friction laws on its carriages.

    Args:
        robot: The robot to start from.
        lower: Law of the lower carriage.
        upper: Law of the upper carriage.

    Returns:
        The robot with these laws.
    """
    return eqx.tree_at(
        lambda r: (r.lower_carriage.friction, r.upper_carriage.friction), robot, (lower, upper)
    )


SMOOTHING_WIDTH = 1e-3
"""Velocity over which `smoothed` lets friction turn round unless it is told another [m/s];
`scdpr reproduce smoothing` has what it costs a fit."""


def smoothed(robot: Robot, *, width: float = SMOOTHING_WIDTH) -> Robot:
    """The robot with smoothed Coulomb friction of its coefficients on both carriages.

    Args:
        robot: A robot of any friction laws.
        width: Velocity over which the friction turns round [m/s].

    Returns:
        The robot for the adaptive solvers of `scdpr_jax.engines.adaptive`.

    Raises:
        ValueError: If the width isn't positive.
    """
    if not width > 0:
        raise ValueError(f"`width` must be positive [m/s], got {width}.")

    def law(friction: Friction) -> SmoothCoulomb:
        return SmoothCoulomb(
            friction.coefficient,
            width,
            friction.viscous,
            friction.static_surplus,
            friction.stribeck_velocity,
        )

    return with_friction(
        robot,
        lower=law(robot.lower_carriage.friction),
        upper=law(robot.upper_carriage.friction),
    )


def exact(robot: Robot) -> Robot:
    """The robot with exact Coulomb friction of its coefficients on both carriages.

    Args:
        robot: A robot of any friction laws.

    Returns:
        The robot for the fixed-grid engine, `scdpr_jax.engines.stepping`.
    """

    def law(friction: Friction) -> Coulomb:
        return Coulomb(
            friction.coefficient,
            friction.viscous,
            friction.static_surplus,
            friction.stribeck_velocity,
        )

    return with_friction(
        robot,
        lower=law(robot.lower_carriage.friction),
        upper=law(robot.upper_carriage.friction),
    )
