"""Section 5.1: what breakaway is said to be."""

from collections.abc import Callable

import jax.numpy as jnp

from experiments.paper.claim import AS_PRINTED, Claim, Verdict, at_least, digits, within
from experiments.paper.topics.breakaway.numbers import (
    NOMINAL,
    START,
    breakaway,
    coefficient,
    moves_with_printed_friction,
    printed_force,
    unbiased_force,
)
from scdpr_jax.robot.drive import motor_current, motor_torque
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.prototype import consistent, published


def _torque(robot_of: Callable[[], Robot]) -> float:
    return float(motor_torque(robot_of().drive, jnp.asarray(0.68)))


CLAIMS: tuple[Claim, ...] = (
    Claim(
        "fig10",
        "5.1",
        "mean of thirty first voltages, friction half a step of the staircase below it",
        "0.68",
        "V",
        within(0.68, 0.03),
        "three standard errors of thirty steps of 0.1 V",
        lambda: breakaway(unbiased_force()).mean,
        Verdict.REPRODUCED,
        "8.3 N of friction on both carriages",
        heavy=True,
    ),
    Claim(
        "fig10",
        "5.1",
        "mean of thirty first voltages, the voltage taken as the friction",
        "0.68",
        "V",
        within(0.68, 0.03),
        "three standard errors of thirty steps of 0.1 V",
        lambda: breakaway(printed_force()).mean,
        Verdict.NOT_REPRODUCIBLE,
        "a staircase overshoots by half a step: E30",
        heavy=True,
    ),
    Claim(
        "fig10",
        "5.1",
        "torque at 0.68 V, k_v of (24)",
        "0.3284 and 0.3268",
        "N m",
        (0.3268, 0.3284),
        "the two printed values",
        lambda: _torque(consistent),
        Verdict.AFTER_ERRATUM,
        "E12: between its two values",
    ),
    Claim(
        "fig10",
        "5.1",
        "torque at 0.68 V, 0.6 A/V · 30.2 mN m/A · 26",
        "0.3284 and 0.3268",
        "N m",
        (0.3268, 0.3284),
        "the two printed values",
        lambda: _torque(published),
        Verdict.NOT_REPRODUCIBLE,
        "E12: the nameplates give 0.320 N m, 2.3 % less",
    ),
    Claim(
        "fig10",
        "5.1",
        "current at 10 V by the nameplates",
        "6",
        "A",
        digits("6"),
        AS_PRINTED,
        lambda: float(motor_current(published().drive, jnp.asarray(10.0))),
        Verdict.GIVEN,
    ),
    Claim(
        "fig10",
        "5.1",
        "torque constant of the motor",
        "30.2",
        "mN m/A",
        digits("30.2"),
        AS_PRINTED,
        lambda: 1e3 * float(published().drive.torque_per_ampere) / 26,
        Verdict.GIVEN,
    ),
    Claim(
        "fig10",
        "5.1",
        "coefficient of friction at 350 N from the breakaway, both carriages",
        "0.1723",
        "1",
        within(0.1723, 0.0172),
        "a tenth, far beyond what 0.68 V bear",
        lambda: coefficient(printed_force(), tension=NOMINAL, carriages=2),
        Verdict.NOT_REPRODUCIBLE,
        "E21: 0.0032, usual for ball bearings; the printed one is 54 times that",
    ),
    Claim(
        "fig10",
        "5.1, Fig. 10",
        "the robot moves with T = 350 N and μ = 0.1723, even at 10 V",
        "moves",
        "m",
        at_least(1e-3),
        "a millimetre is seen",
        moves_with_printed_friction,
        Verdict.NOT_REPRODUCIBLE,
        "E21: 241 N on each carriage hold it against 132 N",
        heavy=True,
    ),
    Claim(
        "fig10",
        "Fig. 10",
        "start of the upper carriage",
        "0.2",
        "m",
        digits("0.2"),
        AS_PRINTED,
        lambda: START,
        Verdict.GIVEN,
    ),
)
"""Claims of section 5.1."""
