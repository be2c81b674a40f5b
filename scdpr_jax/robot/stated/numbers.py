"""The laboratory prototype's numbers, as printed and as its results ask for.

Every number has one home here, with where it comes from. `docs/errata.md` gives the
reasons at length.
"""

from typing import NamedTuple


class Source(NamedTuple):
    """Where a number comes from, and what is printed for it."""

    name: str
    """Name of the quantity, see `scdpr_jax.robot.quantities.QUANTITIES`."""
    published: float
    """As printed, in SI units."""
    consistent: float
    """What reproduces the paper's own results, in SI units."""
    provenance: str
    """Where both come from."""


TORQUE_CONSTANT = 30.2e-3
"""Torque of a motor for an ampere [N m/A], section 5.1."""

GEARBOX = 26.0
"""Reduction of the gearbox, section 4.1."""

PROVENANCE: tuple[Source, ...] = (
    Source("frame_width", 2.224, 2.224, "Table 1"),
    Source("frame_height", 1.112, 1.112, "Table 1"),
    Source("end_effector_mass", 2.1, 2.1, "Table 1"),
    Source("end_effector_inertia", 2.5198e-2, 2.5198e-2, "Table 1"),
    Source("lower_offset", 0.1405, 0.1405, "half of Table 1's height h"),
    Source("upper_offset", 0.1405, 0.1405, "half of Table 1's height h"),
    Source("lower_carriage_mass", 1.2, 1.2, "Table 1"),
    Source("upper_carriage_mass", 1.2, 1.2, "Table 1"),
    Source(
        "friction_coefficient",
        0.1723,
        4.5 / (4 * 85),
        "section 5.1; consistent: 9.0 N at breakaway, half on each carriage, at 85 N",
    ),
    Source(
        "effective_pretension",
        350.0,
        85.0,
        "section 5.1; consistent: the error and rotation of section 6 (50 mm, 3.2 degrees)",
    ),
    Source("effective_radius", 7.3e-3, 73e-3, "Table 1, where millimetres are centimetres"),
    Source("drive_inertia", 1.2734e-2, 1.2734e-2, "Table 1"),
    Source("drive_damping", 0.2, 0.2124, "Table 1; consistent: b/J = 16.68 1/s of Eq. (24)"),
    Source("drive_friction", 0.0, 0.0, "not in the paper's model"),
    Source(
        "torque_per_volt",
        0.6 * TORQUE_CONSTANT * GEARBOX,
        0.482,
        "sections 4.1 and 5.1, nameplates; consistent: the gain 2169 of Eq. (24), in degrees",
    ),
    Source("voltage_limit", 10.0, 10.0, "section 5.1"),
)
"""The prototype's numbers, one row for each named quantity."""
