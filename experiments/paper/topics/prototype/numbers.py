"""Table 1 and what follows from it: inertia, speed, force, voltage, elasticity."""

import functools
from typing import NamedTuple

import jax.numpy as jnp

from scdpr_jax.command.trajectory import table_3
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.loop_elasticity import (
    CableSection,
    consistent_section,
    loop_stiffness,
    published_section,
)
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.prototype import consistent, published

BREAKAWAY_TORQUE = 0.3284
"""Torque of each drive when the robot breaks away, the first of section 5.1's two [N m]."""

TENSION = 350.0
"""Nominal pretension of section 5.1 [N]."""


class Derived(NamedTuple):
    """What Table 1 comes to."""

    reflected_inertia: float
    """Both drives' inertia seen from the cable, $2J/r^2$ [kg]."""
    reflected_damping: float
    """Both drives' damping seen from the cable, $2b/r^2$ [N s/m]."""
    top_speed: float
    """Speed of the cable that a drive reaches at its voltage limit, $r k_v V / b$ [m/s]."""
    largest_force: float
    """Force of both drives at their limit [N]."""
    breakaway_force: float
    """Force of both drives at breakaway, $2\\tau_f/r$ [N]."""
    printed_friction: float
    """Friction of one carriage by section 5.1's numbers, $4T\\mu$ [N]."""
    diagonal_voltage: float
    """Voltage that the diagonal manoeuvre asks for in the middle of a leg [V]."""
    axial_stiffness: float
    """The cable's force per strain, $EA$ [N]."""
    loop_stiffness: float
    """The loop's rise of tension per lengthening, $EA/L$ [N/m]."""
    stretch: float
    """By how much the nominal pretension stretches the loop [m]."""


@functools.cache
def derived_consistently() -> Derived:
    """The derived quantities with the consistent numbers.

    Returns:
        The quantities.
    """
    return derive(consistent(), consistent_section())


@functools.cache
def derived_as_printed() -> Derived:
    """The derived quantities with the numbers as printed.

    Returns:
        The quantities.
    """
    return derive(published(), published_section())


def derive(robot: Robot, section: CableSection) -> Derived:
    """What a robot's numbers come to.

    Args:
        robot: The robot.
        section: Its cable.

    Returns:
        The derived quantities.
    """
    drive, radius = robot.drive, float(robot.drive.effective_radius)
    stall = float(motor_torque(drive, drive.voltage_limit))
    return Derived(
        reflected_inertia=2 * float(drive.inertia) / radius**2,
        reflected_damping=2 * float(drive.damping) / radius**2,
        top_speed=radius * stall / float(drive.damping),
        largest_force=2 * stall / radius,
        breakaway_force=2 * BREAKAWAY_TORQUE / radius,
        printed_friction=4 * TENSION * 0.1723,
        diagonal_voltage=_mid_leg_voltage(robot, leg_time=2.5),
        axial_stiffness=float(section.axial_stiffness),
        loop_stiffness=float(loop_stiffness(robot, section)),
        stretch=TENSION / float(loop_stiffness(robot, section)),
    )


def _mid_leg_voltage(robot: Robot, *, leg_time: float) -> float:
    """Voltage of the faster drive in mid-leg, where no acceleration is asked for [V]."""
    diagonal = table_3(leg_times=(leg_time,) * 3).diagonal
    x, y = diagonal.velocity(jnp.asarray(leg_time / 2))
    rate = abs(float(x + y)) / float(robot.drive.effective_radius)
    return float(robot.drive.damping) * rate / float(robot.drive.torque_per_volt)
