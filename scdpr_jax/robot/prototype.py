"""The laboratory prototype: the paper's robot as printed, and as its results ask for.

Every number has one home here, with where it comes from. `docs/errata.md` gives the
reasons at length.
"""

from typing import NamedTuple

from scdpr_jax.robot.friction import Coulomb
from scdpr_jax.robot.parameters import Cable, Carriage, Drive, EndEffector, Frame, Robot
from scdpr_jax.robot.quantities import replace


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


_TORQUE_CONSTANT = 30.2e-3  # N m/A, section 5.1
_GEARBOX = 26.0  # section 4.1

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
        0.6 * _TORQUE_CONSTANT * _GEARBOX,
        0.482,
        "sections 4.1 and 5.1, nameplates; consistent: the gain 2169 of Eq. (24), in degrees",
    ),
    Source("voltage_limit", 10.0, 10.0, "section 5.1"),
)
"""The prototype's numbers, one row for each named quantity."""


def consistent() -> Robot:
    """The prototype with the numbers that reproduce the paper's own results.

    Returns:
        The default robot, with exact Coulomb friction on both carriages.
    """
    return _prototype({source.name: source.consistent for source in PROVENANCE})


def published() -> Robot:
    """The prototype as printed, misprints included: to compare, not to work with.

    Returns:
        The robot of Table 1 and section 5.1.
    """
    return _prototype({source.name: source.published for source in PROVENANCE})


def _prototype(values: dict[str, float]) -> Robot:
    carriage = Carriage(mass=0.0, width=0.287, friction=Coulomb(0.0))  # width: Table 1
    blank = Robot(
        frame=Frame(width=0.0, height=0.0),
        end_effector=EndEffector(mass=0.0, inertia=0.0, lower_offset=0.0, upper_offset=0.0),
        lower_carriage=carriage,
        upper_carriage=carriage,
        cable=Cable(effective_pretension=0.0),
        drive=Drive(
            effective_radius=0.0,
            inertia=0.0,
            damping=0.0,
            friction=0.0,
            friction_width=0.05,
            torque_per_volt=0.0,
            torque_per_ampere=_TORQUE_CONSTANT * _GEARBOX,
            voltage_limit=0.0,
        ),
    )
    return replace(blank, values)
