"""The robot's named quantities: name, unit, symbol, and where in a robot they stand.

Nothing here needs JAX: a log is read and checked by these names before anything is computed.
"""

import dataclasses
from collections.abc import Callable
from typing import Any


@dataclasses.dataclass(frozen=True)
class Quantity:
    """A named scalar of the robot: one name, one unit, one or more leaves."""

    name: str
    """Name in `campaign.toml` and `parameters.json`."""
    unit: str
    """SI unit."""
    symbol: str
    """Symbol in TeX."""
    leaves: Callable[[Any], tuple[Any, ...]]
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
    Quantity(
        "drive_compliance",
        "m/N",
        "c",
        lambda r: (r.drive.compliance,),
        "give of the cables between drives and lower carriage",
        positive=False,
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
