"""Section 6.1: what drive and controller are said to be."""

import math

from experiments.paper.claim import Claim, Printed, within
from experiments.paper.topics.loop.numbers import (
    designed,
    gain_from_table,
    printed,
    step_response,
)
from scdpr_jax.robot.drive import drive_pole
from scdpr_jax.robot.prototype import consistent, published
from scdpr_jax.robot.quantities import value

_NUMERATOR = Printed(
    "(24)",
    "2169",
    "1/s^2/V",
    within(2169.0, 2.0),
    "a tenth of a per cent: k_v has three digits",
)

EQ24: tuple[Claim, ...] = (
    _NUMERATOR.after_erratum(
        "numerator from a simulated step response, angle in degrees",
        lambda: step_response().gain,
        "E8: degrees and volts",
    ),
    _NUMERATOR.after_erratum(
        "numerator from Table 1 and k_v = 0.482 N m/V", gain_from_table, "E8: (180/π) k_v/J"
    ),
    Printed(
        "(24)", "2169", "1/s^2/V", within(2169.0, 2.0), "a tenth of a per cent"
    ).not_reproducible(
        "numerator as it is named, 1/J",
        lambda: 1 / float(value(consistent(), "drive_inertia")),
        "E8: 78.5 with Table 1",
    ),
    Printed("(24)", "16.68", "1/s").after_erratum(
        "pole from a simulated step response",
        lambda: step_response().pole,
        "E11: with b = 0.2124 N m s",
    ),
    Printed("(24)", "16.68", "1/s", within(16.68, 0.17), "a per cent").not_reproducible(
        "pole b/J with Table 1's b",
        lambda: float(drive_pole(published().drive)),
        "E11: 0.2 has one digit; 15.7",
    ),
    Printed("Table 1", "0.2", "N m s").reproduced(
        "damping b of a drive, from the pole and J",
        lambda: 16.68 * float(value(consistent(), "drive_inertia")),
        "0.2124 rounds to it; the pole needs all digits, E11",
    ),
)
"""Claims on the drive."""

EQ25: tuple[Claim, ...] = (
    Printed("6.1", "40", "rad/s").reproduced(
        "gain crossover of the required controller",
        lambda: float(designed().continuous.gain_crossover),
    ),
    Printed("6.1", "60", "°").reproduced(
        "phase margin of the required controller",
        lambda: math.degrees(designed().continuous.phase_margin),
    ),
    Printed("(25)", "0.6352", "V/°").after_erratum(
        "proportional gain for 40 rad/s and 60°, error in degrees",
        lambda: designed().gains_in_degrees[0],
        "E9: on degrees",
    ),
    Printed("(25)", "0.0125", "V s/°").not_reproducible(
        "derivative gain for 40 rad/s and 60°, error in degrees",
        lambda: designed().gains_in_degrees[1],
        "E10: 0.012126",
    ),
    Printed("6.1, (25)", "40", "rad/s", within(40.0, 0.5), "to the printed digits").reproduced(
        "gain crossover of the printed pair",
        lambda: float(printed().continuous.gain_crossover),
        "40.31 rad/s",
    ),
    Printed("6.1, (25)", "60", "°").not_reproducible(
        "phase margin of the printed pair",
        lambda: math.degrees(printed().continuous.phase_margin),
        "E10: 60.90°, which rounds to 61",
    ),
)
"""Claims on the controller."""
