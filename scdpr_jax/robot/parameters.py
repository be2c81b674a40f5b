"""The robot's parameters: frozen pytrees, every number an array leaf with its unit.

`Quantity` names each of them once, as `campaign.toml`'s `[robot]`, `parameters.json` and
the tables of a report do.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.robot.fields import real, si
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


class Quantity(NamedTuple):
    """A named scalar of the robot: one name, one unit, one or more leaves."""

    name: str
    """Name in `campaign.toml` and `parameters.json`."""
    unit: str
    """SI unit."""
    symbol: str
    """Symbol in TeX."""
    leaves: Callable[[Robot], tuple[Array, ...]]
    """The leaves of a robot that it sets; the first is the one that is read."""
    meaning: str
    """What it is, for a table."""
    positive: bool = True
    """Whether it must be above zero; otherwise it may be zero."""
    signed: bool = False
    """Whether it may be below zero, too."""


QUANTITIES: tuple[Quantity, ...] = (
    Quantity("frame_width", "m", "W", lambda r: (r.frame.width,), "width of the frame"),
    Quantity("frame_height", "m", "H", lambda r: (r.frame.height,), "height of the frame"),
    Quantity(
        "end_effector_mass", "kg", "m_e", lambda r: (r.end_effector.mass,), "end-effector mass"
    ),
    Quantity(
        "end_effector_inertia",
        "kg m^2",
        "I_e",
        lambda r: (r.end_effector.inertia,),
        "end-effector inertia",
    ),
    Quantity(
        "lower_offset",
        "m",
        "a",
        lambda r: (r.end_effector.lower_offset,),
        "attachment below the centre of mass",
    ),
    Quantity(
        "upper_offset",
        "m",
        "b",
        lambda r: (r.end_effector.upper_offset,),
        "attachment above the centre of mass",
    ),
    Quantity(
        "lower_carriage_mass",
        "kg",
        "m_3",
        lambda r: (r.lower_carriage.mass,),
        "lower carriage mass",
    ),
    Quantity(
        "upper_carriage_mass",
        "kg",
        "m_4",
        lambda r: (r.upper_carriage.mass,),
        "upper carriage mass",
    ),
    Quantity(
        "friction_coefficient",
        "1",
        r"\mu",
        lambda r: (
            r.lower_carriage.friction.coefficient,
            r.upper_carriage.friction.coefficient,
        ),
        "friction coefficient of the carriages",
        positive=False,
    ),
    Quantity(
        "effective_pretension",
        "N",
        "T",
        lambda r: (r.cable.effective_pretension,),
        "effective pretension of the loop",
    ),
    Quantity(
        "effective_radius",
        "m",
        "r",
        lambda r: (r.drive.effective_radius,),
        "effective radius of the driver pulleys",
    ),
    Quantity(
        "drive_inertia", "kg m^2", "J", lambda r: (r.drive.inertia,), "inertia of a drive"
    ),
    Quantity("drive_damping", "N m s", "b", lambda r: (r.drive.damping,), "damping of a drive"),
    Quantity(
        "drive_friction",
        "N m",
        r"\tau_f",
        lambda r: (r.drive.friction,),
        "dry friction of a drive, at the output shaft",
        positive=False,
    ),
    Quantity(
        "torque_per_volt",
        "N m/V",
        "k_v",
        lambda r: (r.drive.torque_per_volt,),
        "torque per volt of command",
    ),
    Quantity(
        "voltage_limit", "V", r"V_{max}", lambda r: (r.drive.voltage_limit,), "largest command"
    ),
)
"""Every quantity of a robot that has a name in the file formats."""

REFINEMENTS: tuple[Quantity, ...] = (
    Quantity(
        "upper_friction_coefficient",
        "1",
        r"\mu_4",
        lambda r: (r.upper_carriage.friction.coefficient,),
        "friction coefficient of the upper carriage, where it has its own",
        positive=False,
    ),
    Quantity(
        "drive_friction_difference",
        "N m",
        r"\Delta\tau_f",
        lambda r: (r.drive.friction_difference,),
        "dry friction of the second drive minus that of the first",
        positive=False,
        signed=True,
    ),
    Quantity(
        "loop_stiffness",
        "N/m",
        "k",
        lambda r: (r.cable.stiffness,),
        "rise of the loop's tension per lengthening of its path",
        positive=False,
    ),
    Quantity(
        "lower_carriage_damping",
        "N s/m",
        "d_3",
        lambda r: (r.lower_carriage.friction.viscous,),
        "viscous damping of the lower carriage",
        positive=False,
    ),
    Quantity(
        "upper_carriage_damping",
        "N s/m",
        "d_4",
        lambda r: (r.upper_carriage.friction.viscous,),
        "viscous damping of the upper carriage",
        positive=False,
    ),
    Quantity(
        "static_friction_surplus",
        "1",
        r"\Delta\mu",
        lambda r: (
            r.lower_carriage.friction.static_surplus,
            r.upper_carriage.friction.static_surplus,
        ),
        "by how much the carriages' coefficient of friction is higher at standstill",
        positive=False,
    ),
    Quantity(
        "stribeck_velocity",
        "m/s",
        "v_{st}",
        lambda r: (
            r.lower_carriage.friction.stribeck_velocity,
            r.upper_carriage.friction.stribeck_velocity,
        ),
        "velocity over which that decays",
    ),
)
"""What a fit may free besides: `campaign.toml` doesn't state it, and it refines a quantity
of `QUANTITIES`, so it is replaced after those."""

EVERY_QUANTITY: tuple[Quantity, ...] = (*QUANTITIES, *REFINEMENTS)
"""Everything of a fitted robot that has a name, in the order of replacing."""


def quantity(name: str) -> Quantity:
    """The named quantity.

    Args:
        name: A name of `QUANTITIES` or `REFINEMENTS`.

    Returns:
        The quantity of that name.

    Raises:
        ValueError: If there is none.
    """
    for candidate in EVERY_QUANTITY:
        if candidate.name == name:
            return candidate
    names = ", ".join(candidate.name for candidate in EVERY_QUANTITY)
    raise ValueError(f"unknown quantity {name!r}, expected one of: {names}.")


def value(robot: Robot, name: str) -> Float[Array, "..."]:
    """The robot's value of a named quantity.

    Args:
        robot: The robot.
        name: A name of `QUANTITIES`.

    Returns:
        Its value [in the quantity's unit].

    Raises:
        ValueError: If the name is unknown.
    """
    return quantity(name).leaves(robot)[0]


def replace(robot: Robot, values: dict[str, Any]) -> Robot:
    """The robot with some of its quantities set anew.

    Args:
        robot: The robot to start from.
        values: New value [in the quantity's SI unit] by name; may be traced.

    Returns:
        A robot in which every leaf of these quantities is replaced.

    Raises:
        ValueError: If a name is unknown.
    """
    refining = {refinement.name for refinement in REFINEMENTS}
    for name, number in sorted(values.items(), key=lambda item: item[0] in refining):
        leaves = quantity(name).leaves
        number = jnp.asarray(number, dtype=leaves(robot)[0].dtype)
        robot = eqx.tree_at(leaves, robot, (number,) * len(leaves(robot)))
    return robot


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
