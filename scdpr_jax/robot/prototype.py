"""The laboratory prototype: the paper's robot as printed, and as its results ask for.

Every number has its home in `scdpr_jax.robot.stated.numbers`.
"""

from scdpr_jax.robot.friction import Coulomb
from scdpr_jax.robot.parameters import Cable, Carriage, Drive, EndEffector, Frame, Robot
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.stated.numbers import GEARBOX, TORQUE_CONSTANT
from scdpr_jax.robot.stated.numbers import PROVENANCE as PROVENANCE
from scdpr_jax.robot.stated.numbers import Source as Source


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
            torque_per_ampere=TORQUE_CONSTANT * GEARBOX,
            voltage_limit=0.0,
        ),
    )
    return replace(blank, values)
