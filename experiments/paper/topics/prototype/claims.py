"""Section 4: what Table 1 and the vision system are said to be."""

from collections.abc import Callable

from experiments.paper.claim import Claim, Printed, at_most, within
from experiments.paper.topics.prototype.numbers import derived_consistently
from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.sensors import Camera, Encoder
from scdpr_jax.robot.loop_elasticity import consistent_section
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import value


def _robot(name: str, scale: float = 1.0) -> Callable[[], float]:
    return lambda: scale * float(value(consistent(), name))


def _offsets() -> float:
    return 1e3 * float(
        value(consistent(), "lower_offset") + value(consistent(), "upper_offset")
    )


TABLE1: tuple[Claim, ...] = (
    Printed("Table 1", "2224", "mm").given("width W of the frame", _robot("frame_width", 1e3)),
    Printed("Table 1", "1112", "mm").given(
        "height H of the frame", _robot("frame_height", 1e3)
    ),
    Printed("Table 1", "287", "mm").given(
        "width w₃ = w₄ of the carriages", lambda: 1e3 * float(consistent().lower_carriage.width)
    ),
    Printed("Table 1", "281", "mm").given("height h of the end-effector, a + b", _offsets),
    Printed("Table 1", "2.1", "kg").given(
        "mass of the end-effector", _robot("end_effector_mass")
    ),
    Printed("Table 1", "2.5198e-2", "kg m^2").given(
        "inertia of the end-effector", _robot("end_effector_inertia")
    ),
    Printed("Table 1", "1.2", "kg").given("mass m₃ = m₄", _robot("lower_carriage_mass")),
    Printed("Table 1", "2", "mm").given(
        "diameter of the cable", lambda: 1e3 * float(consistent_section().diameter)
    ),
    Printed("Table 1", "1.2734e-2", "kg m^2").given(
        "inertia J of a drive", _robot("drive_inertia")
    ),
    Printed(
        "Table 1",
        "7.3",
        "mm",
        within(73.0, 2.0),
        "“near” the limit: 3 %; the print taken as centimetres",
    ).after_erratum(
        "effective radius r: the one whose diagonal manoeuvre asks for 10 V",
        lambda: 7.3 * derived_consistently().diagonal_voltage,
        "E1: 73 mm; at 7.3 mm the drives would need about 100 V",
    ),
    Printed(
        "Table 1, 2.2", "negligible", "mm", at_most(8.3), "a thousandth of the loop's 8.3 m"
    ).after_erratum(
        "stretch of the loop at 350 N, called negligible",
        lambda: 1e3 * derived_consistently().stretch,
        "E14: with steel's 209.12 GPa; with the printed 2.0912 GPa it is 440 mm",
    ),
    Printed("2.1", "2", "kg").reproduced(
        "mass of the end-effector, Table 1's", _robot("end_effector_mass"), "2.1 kg rounded"
    ),
    Printed("2.1", "0.287", "mm").not_reproducible(
        "height of the end-effector, Table 1's",
        _offsets,
        "E13: 281 mm in Table 1; unit and number are another",
    ),
    Printed("4.1", "26", "1").given(
        "gear ratio, from torque per ampere over the torque constant",
        lambda: float(consistent().drive.torque_per_ampere) / 30.2e-3,
    ),
    Printed("4.1", "1", "kHz").given(
        "sampling frequency", lambda: 1e-3 / float(published_pd().period)
    ),
    Printed("4.1", "256", "1").reproduced(
        "encoder: pulses a turn of the motor, from 26624 counts a turn of the pulley",
        lambda: float(Encoder().counts_per_rev) / (4 * 26),
        "four counts a pulse, 26:1",
    ),
    Printed("4.2", "8", "Mpx").reproduced(
        "resolution of the camera from 3264 × 2448", lambda: 3264 * 2448 / 1e6
    ),
    Printed(
        "4.2",
        "0.19",
        "mm",
        within(0.19, 0.02),
        "a tenth of the picture beside the frame, which is cut off",
    ).reproduced(
        "0.26 px in the plane of the robot, the frame as wide as the picture",
        lambda: 0.26 * 2224 / 3264,
        "exact where the frame takes 3043 of the 3264 px",
    ),
    Printed("4.2", "30", "Hz").given("frames a second", lambda: float(Camera().frame_rate)),
)
"""Claims of section 4."""
