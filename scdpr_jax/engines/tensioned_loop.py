r"""A loop of elastic cable whose tension a sensor and a linear actuator hold, Fig. 21.

$$ T = \max(0,\; T_0 + k_L (\Delta L(q) - s - c)), \qquad
   \dot s = \mathrm{sat}(\kappa (T - T^*)) $$

with the path's lengthening $\Delta L$, the actuator's travel $s$ (which shortens what it has
to take up when it is positive), and the cable's creep $c$. The loop's force is the tension
times the gradient of its length, as in Eqs. (7), (8), (16), so that the robot's equations
stay what they are, with a tension that moves.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax import native
from scdpr_jax.engines.arguments import check_shape, check_start
from scdpr_jax.engines.stepping import Inputs, possible_inputs, step, with_start
from scdpr_jax.numerics.lean_scan import lean_scan
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.loop_elasticity import lengthening
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import State


class Tensioner(eqx.Module):
    """An elastic loop with a tension sensor and a linear actuator."""

    loop_stiffness: Float[Array, "..."] = eqx.field(converter=real, metadata=si("N/m", "k_L"))
    """Rise of the tension per lengthening $k_L$ [N/m]."""
    setpoint: Float[Array, "..."] = eqx.field(converter=real, metadata=si("N", "T^*"))
    """Tension that the actuator holds $T^*$ [N]."""
    gain: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m/s/N", r"\kappa"))
    r"""Speed of the actuator per error of the tension $\kappa$ [m/s/N]; 0 for none."""
    top_speed: Float[Array, "..."] = eqx.field(converter=real, metadata=si("m/s", r"v_{max}"))
    """Largest speed of the actuator of either sign [m/s]."""

    @property
    def time_constant(self) -> Float[Array, "..."]:
        r"""Time in which it takes up an error of the tension, $1/(k_L \kappa)$ [s]."""
        return 1 / (self.loop_stiffness * self.gain)


class TensionedRun(NamedTuple):
    """A run of the robot on its elastic loop, at the ends of the intervals."""

    states: State
    """States of the robot."""
    tension: Float[Array, " samples"]
    """Tension of the loop [N]."""
    travel: Float[Array, " samples"]
    """Travel of the actuator [m]."""


def simulate_tensioned(
    tensioner: Tensioner,
    robot: Robot,
    start: State,
    inputs: Inputs,
    *,
    creep: Float[Array, " samples"],
) -> TensionedRun:
    r"""The robot on its elastic loop, with exact friction.

    A step goes half its way with the tension at its beginning, and the whole of it with the
    tension found there: second order in its length. Friction follows the tension.

    Args:
        tensioner: The loop, its sensor and actuator.
        robot: The robot, with `Coulomb` friction on both carriages; its tension isn't used.
        start: State at the first instant, at which the tension is the setpoint's.
        inputs: Commands and knocks, one row for each of `n` intervals.
        creep: The cable's creep at the `n + 1` ends of the intervals [m].

    Returns:
        The run.

    Raises:
        TypeError: If a carriage has another friction law.
        ValueError: If a shape is another, a duration is negative, or a number isn't finite.
    """
    check_start(robot, start)
    inputs = possible_inputs(inputs)
    check_shape(creep, (jnp.shape(inputs.duration)[0] + 1,), name="creep", unit="m")
    reference = lengthening(robot, start.position) - creep[0]

    def tension(
        state: State, travel: Float[Array, ""], crept: Float[Array, ""]
    ) -> Float[Array, ""]:
        longer = lengthening(robot, state.position) - reference - travel - crept
        return jnp.maximum(tensioner.setpoint + tensioner.loop_stiffness * longer, 0)

    def speed(pull: Float[Array, ""]) -> Float[Array, ""]:
        asked = tensioner.gain * (pull - tensioner.setpoint)
        return jnp.clip(asked, -tensioner.top_speed, tensioner.top_speed)

    def advance(
        _: None,
        carry: tuple[State, Float[Array, ""]],
        given: tuple[Inputs, Float[Array, ""], Float[Array, ""]],
    ) -> tuple[
        tuple[State, Float[Array, ""]], tuple[State, Float[Array, ""], Float[Array, ""]]
    ]:
        state, travel = carry
        inputs, before, after = given
        pull = tension(state, travel, before)
        half = Inputs(inputs.duration / 2, inputs.voltage, inputs.knock)
        middle = step(_at(robot, pull), state, half)
        halfway = travel + inputs.duration / 2 * speed(pull)
        pull = tension(middle, halfway, (before + after) / 2)
        following = step(_at(robot, pull), state, inputs)
        moved = travel + inputs.duration * speed(pull)
        return (following, moved), (following, tension(following, moved, after), moved)

    none = jnp.zeros_like(tensioner.setpoint)
    first = (start, tension(start, none, creep[0]), none)
    _, following = native.run(advance, None, (start, none), (inputs, creep[:-1], creep[1:]))
    return TensionedRun(*with_start(first, following))


def held_tension(
    tensioner: Tensioner,
    *,
    times: Float[Array, " samples"],
    creep: Float[Array, " samples"],
) -> Float[Array, " samples"]:
    r"""Tension of a resting robot while its cable creeps, over hours.

    $$ \dot T = -k_L (\dot c + \mathrm{sat}(\kappa (T - T^*))) $$

    Between the given times the cable creeps evenly, and the equation is solved exactly for
    an actuator that keeps up, as one does whose top speed exceeds the creep's.

    Args:
        tensioner: The loop, its sensor and actuator; without gain it isn't held.
        times: Times, ascending [s].
        creep: The cable's creep at these times [m].

    Returns:
        Tension, the setpoint's at first; 0 where the loop has gone slack [N].
    """

    def advance(
        deviation: Float[Array, ""], given: tuple[Float[Array, ""], Float[Array, ""]]
    ) -> tuple[Float[Array, ""], Float[Array, ""]]:
        duration, crept = given
        rate = tensioner.loop_stiffness * tensioner.gain * duration
        # (1 - exp(-rate)) / rate, one without an actuator.
        share = jnp.where(rate == 0, 1, -jnp.expm1(-rate) / jnp.where(rate == 0, 1, rate))
        following = deviation * jnp.exp(-rate) - tensioner.loop_stiffness * crept * share
        return following, following

    none = jnp.zeros_like(tensioner.setpoint)
    _, later = lean_scan(advance, none, (jnp.diff(times), jnp.diff(creep)))
    return jnp.maximum(tensioner.setpoint + jnp.concatenate([none[None], later]), 0)


def logarithmic_creep(
    times: Float[Array, " samples"],
    *,
    strain_per_decade: Float[Array, ""],
    onset: Float[Array, ""],
    length: Float[Array, ""],
) -> Float[Array, " samples"]:
    r"""Primary creep of a cable under an even load, $c = L \epsilon_{10} \log_{10}(1 + t/t_1)$.

    The logarithmic law of low temperatures, which steel follows far below its melting
    point: A. H. Cottrell, "The time laws of creep", J. Mech. Phys. Solids 1 (1952) 53-63.

    Args:
        times: Times under load [s].
        strain_per_decade: Creep strain per tenfold time $\epsilon_{10}$ [1].
        onset: Time $t_1$ from which on it counts [s].
        length: Length of the cable $L$ [m].

    Returns:
        Lengthening [m].
    """
    return length * strain_per_decade * jnp.log10(1 + times / onset)


def _at(robot: Robot, tension: Float[Array, ""]) -> Robot:
    return replace(robot, {"effective_pretension": tension})
