"""Section 4: what Table 1 and the vision system are said to be."""

from collections.abc import Callable

from experiments.paper.claim import AS_PRINTED, Claim, Verdict, at_most, digits, within
from experiments.paper.topics.prototype.numbers import derived_consistently
from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.sensors import Camera, Encoder
from scdpr_jax.robot.loop_elasticity import consistent_section
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import value


def _given(where: str, what: str, printed: str, unit: str, held: Callable[[], float]) -> Claim:
    return Claim(
        "table1", where, what, printed, unit, digits(printed), AS_PRINTED, held, Verdict.GIVEN
    )


def _robot(name: str, scale: float = 1.0) -> Callable[[], float]:
    return lambda: scale * float(value(consistent(), name))


def _offsets() -> float:
    return 1e3 * float(
        value(consistent(), "lower_offset") + value(consistent(), "upper_offset")
    )


CLAIMS: tuple[Claim, ...] = (
    _given("Table 1", "width W of the frame", "2224", "mm", _robot("frame_width", 1e3)),
    _given("Table 1", "height H of the frame", "1112", "mm", _robot("frame_height", 1e3)),
    _given(
        "Table 1",
        "width w₃ = w₄ of the carriages",
        "287",
        "mm",
        lambda: 1e3 * float(consistent().lower_carriage.width),
    ),
    _given("Table 1", "height h of the end-effector, a + b", "281", "mm", _offsets),
    _given("Table 1", "mass of the end-effector", "2.1", "kg", _robot("end_effector_mass")),
    _given(
        "Table 1",
        "inertia of the end-effector",
        "2.5198e-2",
        "kg m^2",
        _robot("end_effector_inertia"),
    ),
    _given("Table 1", "mass m₃ = m₄", "1.2", "kg", _robot("lower_carriage_mass")),
    _given(
        "Table 1",
        "diameter of the cable",
        "2",
        "mm",
        lambda: 1e3 * float(consistent_section().diameter),
    ),
    _given("Table 1", "inertia J of a drive", "1.2734e-2", "kg m^2", _robot("drive_inertia")),
    Claim(
        "table1",
        "Table 1",
        "effective radius r: the one whose diagonal manoeuvre asks for 10 V",
        "7.3",
        "mm",
        within(73.0, 2.0),
        "“near” the limit: 3 %; the print taken as centimetres",
        lambda: 7.3 * derived_consistently().diagonal_voltage,
        Verdict.AFTER_ERRATUM,
        "E1: 73 mm; at 7.3 mm the drives would need about 100 V",
    ),
    Claim(
        "table1",
        "Table 1, 2.2",
        "stretch of the loop at 350 N, called negligible",
        "negligible",
        "mm",
        at_most(8.3),
        "a thousandth of the loop's 8.3 m",
        lambda: 1e3 * derived_consistently().stretch,
        Verdict.AFTER_ERRATUM,
        "E14: with steel's 209.12 GPa; with the printed 2.0912 GPa it is 440 mm",
    ),
    Claim(
        "table1",
        "2.1",
        "mass of the end-effector, Table 1's",
        "2",
        "kg",
        digits("2"),
        AS_PRINTED,
        _robot("end_effector_mass"),
        Verdict.REPRODUCED,
        "2.1 kg rounded",
    ),
    Claim(
        "table1",
        "2.1",
        "height of the end-effector, Table 1's",
        "0.287",
        "mm",
        digits("0.287"),
        AS_PRINTED,
        _offsets,
        Verdict.NOT_REPRODUCIBLE,
        "E13: 281 mm in Table 1; unit and number are another",
    ),
    _given(
        "4.1",
        "gear ratio, from torque per ampere over the torque constant",
        "26",
        "1",
        lambda: float(consistent().drive.torque_per_ampere) / 30.2e-3,
    ),
    _given(
        "4.1", "sampling frequency", "1", "kHz", lambda: 1e-3 / float(published_pd().period)
    ),
    Claim(
        "table1",
        "4.1",
        "encoder: pulses a turn of the motor, from 26624 counts a turn of the pulley",
        "256",
        "1",
        digits("256"),
        AS_PRINTED,
        lambda: float(Encoder().counts_per_rev) / (4 * 26),
        Verdict.REPRODUCED,
        "four counts a pulse, 26:1",
    ),
    Claim(
        "table1",
        "4.2",
        "resolution of the camera from 3264 × 2448",
        "8",
        "Mpx",
        digits("8"),
        AS_PRINTED,
        lambda: 3264 * 2448 / 1e6,
        Verdict.REPRODUCED,
    ),
    Claim(
        "table1",
        "4.2",
        "0.26 px in the plane of the robot, the frame as wide as the picture",
        "0.19",
        "mm",
        within(0.19, 0.02),
        "a tenth of the picture beside the frame, which is cut off",
        lambda: 0.26 * 2224 / 3264,
        Verdict.REPRODUCED,
        "exact where the frame takes 3043 of the 3264 px",
    ),
    _given("4.2", "frames a second", "30", "Hz", lambda: float(Camera().frame_rate)),
)
"""Claims of section 4."""
