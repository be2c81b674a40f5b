"""Figure 10 and section 5.1: the voltage at which the robot breaks away, thirty times."""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.engines.stepping import Inputs, simulate
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.friction import Coulomb
from scdpr_jax.robot.parameters import with_friction
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import UPPER, rest

REPEATS = 30
"""Repetitions, as in section 5.1."""

SPREAD = 0.1
"""Standard deviation of a carriage's friction over its mean [1]; none is printed."""

STEP = 0.1
"""Step of the staircase [V]."""

PRINTED_VOLTAGE = 0.68
"""Mean voltage at breakaway, section 5.1 [V]."""

NOMINAL = 350.0
"""Pretension of section 5.1 [N]."""

START = 0.2
"""Where the carriages start [m], Figure 10."""

_PERIOD, _HELD, _STEPS = 2e-3, 500, 13
_SEEN = 0.5e-3  # m: two and a half times what the vision system errs by


class Breakaway(NamedTuple):
    """Thirty staircases, and thirty steps to the printed voltage."""

    friction: Float[np.ndarray, "repeats 2"]
    """Friction of the lower and the upper carriage [N]."""
    voltage: Float[np.ndarray, " repeats"]
    """First voltage at which the upper carriage is seen to move [V]."""
    lower_voltage: Float[np.ndarray, " repeats"]
    """First voltage at which the lower carriage is seen to move [V]."""
    time: Float[np.ndarray, " samples"]
    """Times of the steps [s]."""
    upper: Float[np.ndarray, "repeats samples"]
    """Upper carriage with the printed voltage on both drives from rest [m]."""

    @property
    def mean(self) -> float:
        """Mean voltage [V]."""
        return float(self.voltage.mean())

    @property
    def force(self) -> float:
        """Mean friction of both carriages together [N]."""
        return float(self.friction.sum(axis=1).mean())


@functools.cache
def breakaway(force: float) -> Breakaway:
    """Thirty repetitions, the friction of each carriage drawn anew.

    Args:
        force: Mean friction of both carriages together [N].

    Returns:
        What is observed.
    """
    drawn = np.random.default_rng(10).standard_normal((REPEATS, 2))
    drawn -= drawn.mean(axis=0)
    friction = force / 2 * (1 + SPREAD * drawn)
    stairs = STEP * np.repeat(np.arange(_STEPS), _HELD)
    climbed = _carriages(jnp.asarray(friction), jnp.asarray(stairs))
    constant = _carriages(jnp.asarray(friction), jnp.full(stairs.shape, PRINTED_VOLTAGE))
    lower, upper = (_first_voltage(climbed[..., c], stairs) for c in (0, 1))
    time = _PERIOD * np.arange(stairs.size + 1)
    return Breakaway(friction, upper, lower, time, constant[..., 1])


def _first_voltage(
    place: Float[np.ndarray, "repeats samples"], stairs: Float[np.ndarray, " steps"]
) -> Float[np.ndarray, " repeats"]:
    moved = np.abs(place[:, 1:] - START) > _SEEN
    first = np.where(moved.any(axis=1), stairs[np.argmax(moved, axis=1)], np.nan)
    return first


def _carriages(
    friction: Float[Array, "repeats 2"], voltage: Float[Array, " steps"]
) -> Float[np.ndarray, "repeats samples 2"]:
    return np.asarray(_simulated(friction, voltage))


@eqx.filter_jit
def _simulated(
    friction: Float[Array, "repeats 2"], voltage: Float[Array, " steps"]
) -> Float[Array, "repeats samples 2"]:
    robot = consistent()
    normal = 4 * value(robot, "effective_pretension")
    inputs = Inputs(
        jnp.full(voltage.shape, _PERIOD),
        jnp.stack([voltage, voltage], axis=1),
        jnp.zeros_like(voltage),
    )

    def run(forces: Float[Array, "2"]) -> Float[Array, "samples 2"]:
        lower, upper = (Coulomb(force / normal) for force in forces)
        here = jnp.asarray(START)
        rubbed = with_friction(robot, lower=lower, upper=upper)
        start = rest(rubbed, here, here, robot.frame.height / 2)
        return simulate(rubbed, start, inputs).carriages

    return jax.vmap(run)(friction)


def printed_force() -> float:
    """Force of both drives at the printed voltage, $2 k_v V_f / r$.

    Returns:
        Force [N].
    """
    drive = consistent().drive
    torque = float(motor_torque(drive, jnp.asarray(PRINTED_VOLTAGE)))
    return 2 * torque / float(drive.effective_radius)


def unbiased_force() -> float:
    """Friction of both carriages whose staircase has the printed mean, half a step lower.

    The first step at which something moves lies half a step above the force on average.

    Returns:
        Force [N].
    """
    return printed_force() * (PRINTED_VOLTAGE - STEP / 2) / PRINTED_VOLTAGE


def coefficient(force: float, *, tension: float, carriages: int) -> float:
    """The coefficient of friction that a force and a tension give.

    Args:
        force: Friction of all carriages together [N].
        tension: Tension of the loop [N].
        carriages: How many carriages it holds.

    Returns:
        Coefficient [1].
    """
    return force / (carriages * 4 * tension)


@functools.cache
def moves_with_printed_friction() -> float:
    """How far the robot goes in a second at 10 V with T = 350 N and the printed μ.

    Returns:
        Distance of the upper carriage [m].
    """
    stuck = replace(
        consistent(), {"effective_pretension": NOMINAL, "friction_coefficient": 0.1723}
    )
    inputs = Inputs(jnp.full(500, _PERIOD), jnp.full((500, 2), 10.0), jnp.zeros(500))
    here = jnp.asarray(START)
    start = rest(stuck, here, here, stuck.frame.height / 2)
    end = eqx.filter_jit(simulate)(stuck, start, inputs).position[-1, UPPER]
    return float(end) - START
