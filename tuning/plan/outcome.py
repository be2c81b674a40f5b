r"""What a plan's legs come to on robots as they might be, and the residuals of it.

What is to vanish is a state: everything at rest, in line, at the target, as the drives stop.
Asked for at once that is a narrow valley. While both carriages slide, though, friction is a
constant force and the state as the drives stop is nearly linear in the motion: so the fitted
robot's `arriving` leads into the valley, and `resting` of all robots goes down in it.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.legs.ensemble import Ensemble
from scdpr_jax.native import kept_jit
from scdpr_jax.robot.parameters import Robot
from tuning.plan.feedforward import Motion
from tuning.plan.following import Followed, follow
from tuning.plan.grid import Grid, led

_VIBRATION = 0.3e-3
"""Distance from where it rests, once the drives hold, that counts as one [m]."""
_RESTING = 1e-3
"""Distance of that place from the target that counts as one [m]: friction that isn't known
decides it more than any motion does."""
_TRACKING = 100e-3
"""Distance from the plain profile during the leg that counts as one [m]."""
_VOLTAGE_SHARE = 0.85
"""Share of the voltage limit beyond which commands cost; the rest is the PD's [1]."""
_VOLTAGE = 0.5
"""Excess of a command that counts as one [V]."""
_OUTSIDE = 1e-3
"""How far out of the frame the lower carriage counts as one [m]."""
_ROUGHNESS = 0.5
"""Second difference of the splines' coefficients that counts as one [m]."""
_ARRIVAL = 0.1e-3
"""Distance of the fitted robot from rest at the target that counts as one, when a first
guess is sought [m]; velocities count over an angular frequency of 3 Hz."""


Pairs = list[tuple[np.ndarray, np.ndarray]]
"""Residuals with their Jacobians."""


class Outcome(NamedTuple):
    """What the robots' legs come to, in SI units, every fourth sample of them."""

    after: Float[Array, "robots samples"]
    """Distance of $x_e$ from the target once the drives hold [m]."""
    during: Float[Array, "robots samples"]
    """Distance of $x_e$ from the plain profile until then [m]."""
    excess: Float[Array, "robots samples"]
    """Commands beyond what is left to the PD [V]."""
    arrival: Float[Array, "robots 6"]
    """State of $[x_e, \\delta_e, q_4]$ as the drives stop, less rest in line [m, rad and m/s,
    rad/s]. As long as both carriages slide it is linear in the motion."""
    outside: Float[Array, " samples"]
    """How far the lower carriage is led out of the frame [m]."""


jax.export.register_namedtuple_serialization(Outcome, serialized_name="Outcome")


def run_planned(
    robot: Ensemble, controller: PD, on: Grid, coefficients: Float[Array, " splines"]
) -> Followed:
    """A robot as it might be on a leg, its own dynamics inverted.

    The encoders show no start out of line: the motion is relative to where it begins.

    Args:
        robot: The robot with its start.
        controller: The PD controller.
        on: The grid.
        coefficients: Coefficients of the splines [m].

    Returns:
        The run.
    """
    start = robot.start
    shift = (start.driven - on.instants.position[0])[None]
    instants, middles = (
        Motion(motion.position + shift, motion.velocity, motion.acceleration)
        for motion in led(on, coefficients)
    )
    return follow(
        robot.robot, controller, start, instants=instants, middles=middles, period=on.period
    )


@kept_jit
def linearised(
    robots: Ensemble,
    controller: PD,
    on: Grid,
    coefficients: Float[Array, " splines"],
    *,
    holding: int,
) -> tuple[Outcome, Outcome]:
    """The outcome and its Jacobian, by forward mode through every stop and start.

    Args:
        robots: The robots, the fitted one first.
        controller: The PD controller.
        on: The grid.
        coefficients: Coefficients of the splines [m].
        holding: Intervals until the drives hold.

    Returns:
        Both; the Jacobian's last axes are the coefficients.
    """

    def outcome(coefficients: Float[Array, " splines"]) -> Outcome:
        runs = jax.vmap(lambda robot: run_planned(robot, controller, on, coefficients))
        fitted = jax.tree.map(lambda leaf: leaf[0], robots.robot)
        return _judged(fitted, runs(robots), on, coefficients, holding=holding)

    directions = jnp.eye(coefficients.size, dtype=coefficients.dtype)
    return jax.vmap(
        lambda direction: jax.jvp(outcome, (coefficients,), (direction,)),
        out_axes=(None, -1),
    )(directions)


def _judged(
    robot: Robot,
    runs: Followed,
    on: Grid,
    coefficients: Float[Array, " splines"],
    *,
    holding: int,
) -> Outcome:
    x, goal = runs.states.position[:, :, 0], on.ends[-1, 0]
    plain = on.ends[: holding - 1 : 4, 0][None]
    moving = jnp.asarray((0, 1, 3))
    target = jnp.stack([goal, jnp.zeros_like(goal), goal])[None]
    away = runs.states.position[:, holding - 1][:, moving] - target
    speed = runs.states.velocity[:, holding - 1][:, moving]
    excess = jnp.abs(runs.voltage[:, ::4]) - _VOLTAGE_SHARE * robot.drive.voltage_limit
    lower = led(on, coefficients)[0].position[::4, 0]
    return Outcome(
        after=x[:, holding - 1 :: 4] - goal,
        during=x[:, : holding - 1 : 4] - plain,
        excess=jnp.maximum(excess, 0.0).reshape(x.shape[0], -1),
        arrival=jnp.concatenate([away, speed], axis=1),
        outside=jnp.maximum(-lower, 0.0) + jnp.maximum(lower - robot.frame.width, 0.0),
    )


def common(value: Outcome, slope: Outcome, weights: Float[np.ndarray, " robots"]) -> Pairs:
    """What every search minds: the plain profile, the drives' limit, the frame.

    Args:
        value: The outcome.
        slope: Its Jacobian.
        weights: How much each robot counts [1].

    Returns:
        Residuals with their Jacobians.
    """
    return [
        _weighted(value.during, slope.during, weights / _TRACKING),
        _weighted(value.excess, slope.excess, weights / _VOLTAGE),
        (value.outside / _OUTSIDE, slope.outside / _OUTSIDE),
    ]


def resting(value: Outcome, slope: Outcome, weights: Float[np.ndarray, " robots"]) -> Pairs:
    """Rest for all robots, and at the target.

    Args:
        value: The outcome.
        slope: Its Jacobian.
        weights: How much each robot counts [1].

    Returns:
        Residuals with their Jacobians.
    """
    mean, its_slope = (part.after.mean(axis=1, keepdims=True) for part in (value, slope))
    count = np.sqrt(value.after.shape[1])
    return [
        _weighted(value.after - mean, slope.after - its_slope, weights / _VIBRATION),
        _weighted(count * mean, count * its_slope, weights / _RESTING),
    ]


def arriving(value: Outcome, slope: Outcome, weights: Float[np.ndarray, " robots"]) -> Pairs:
    """Rest in line for the fitted robot, as the leg ends: it leads to the valley.

    Args:
        value: The outcome.
        slope: Its Jacobian.
        weights: How much each robot counts [1].

    Returns:
        Residuals with their Jacobians.
    """
    # Rotations count by the attachments' way, the light upper carriage by less.
    scale = np.tile((1.0, 0.1, 0.3), 2) / _ARRIVAL
    scale[3:] /= 2 * np.pi * 3.0
    return [(value.arrival[0] * scale, slope.arrival[0] * scale[:, None])]


def roughness(point: Float[np.ndarray, " splines"]) -> tuple[np.ndarray, np.ndarray]:
    """How uneven the splines' coefficients are: what no robot minds is left smooth.

    Args:
        point: The coefficients [m].

    Returns:
        Residuals with their Jacobian.
    """
    second = np.diff(np.eye(point.size), 2, axis=0) / _ROUGHNESS
    return second @ point, second


def _weighted(
    value: np.ndarray, slope: np.ndarray, weights: Float[np.ndarray, " robots"]
) -> tuple[np.ndarray, np.ndarray]:
    return value * weights[:, None], slope * weights[:, None, None]
