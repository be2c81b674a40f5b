"""Section 5.1: what breakaway is said to be."""

from collections.abc import Callable

import jax.numpy as jnp

from experiments.paper.claim import Claim, Printed, at_least, within
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


_VOLTAGE = Printed(
    "5.1", "0.68", "V", within(0.68, 0.03), "three standard errors of thirty steps of 0.1 V"
)
_TORQUE = Printed("5.1", "0.3284 and 0.3268", "N m", (0.3268, 0.3284), "the two printed values")

FIG10: tuple[Claim, ...] = (
    _VOLTAGE.reproduced(
        "mean of thirty first voltages, friction half a step of the staircase below it",
        lambda: breakaway(unbiased_force()).mean,
        "8.3 N of friction on both carriages",
        heavy=True,
    ),
    _VOLTAGE.not_reproducible(
        "mean of thirty first voltages, the voltage taken as the friction",
        lambda: breakaway(printed_force()).mean,
        "a staircase overshoots by half a step: E30",
        heavy=True,
    ),
    _TORQUE.after_erratum(
        "torque at 0.68 V, k_v of (24)",
        lambda: _torque(consistent),
        "E12: between its two values",
    ),
    _TORQUE.not_reproducible(
        "torque at 0.68 V, 0.6 A/V · 30.2 mN m/A · 26",
        lambda: _torque(published),
        "E12: the nameplates give 0.320 N m, 2.3 % less",
    ),
    Printed("5.1", "6", "A").given(
        "current at 10 V by the nameplates",
        lambda: float(motor_current(published().drive, jnp.asarray(10.0))),
    ),
    Printed("5.1", "30.2", "mN m/A").given(
        "torque constant of the motor",
        lambda: 1e3 * float(published().drive.torque_per_ampere) / 26,
    ),
    Printed(
        "5.1", "0.1723", "1", within(0.1723, 0.0172), "a tenth, far beyond what 0.68 V bear"
    ).not_reproducible(
        "coefficient of friction at 350 N from the breakaway, both carriages",
        lambda: coefficient(printed_force(), tension=NOMINAL, carriages=2),
        "E21: 0.0032, usual for ball bearings; the printed one is 54 times that",
    ),
    Printed(
        "5.1, Fig. 10", "moves", "m", at_least(1e-3), "a millimetre is seen"
    ).not_reproducible(
        "the robot moves with T = 350 N and μ = 0.1723, even at 10 V",
        moves_with_printed_friction,
        "E21: 241 N on each carriage hold it against 132 N",
        heavy=True,
    ),
    Printed("Fig. 10", "0.2", "m").given("start of the upper carriage", lambda: START),
)
"""Claims of section 5.1."""
