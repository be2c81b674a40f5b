"""Where the linear model (18) holds, and when the carriages stick."""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from experiments.paper.topics.manoeuvres.numbers import with_tension
from scdpr_jax.engines.linear_stepping import simulate_linear
from scdpr_jax.engines.stepping import Inputs, simulate
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.dynamics import masses
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.state import LOWER, X, carriages, pose, rest

HEIGHTS = tuple(np.linspace(0.2, 0.9, 6).tolist())
"""Heights of the map [m]."""

TENSIONS = (50.0, 85.0, 150.0, 350.0)
"""Effective pretensions of the map [N]."""

VOLTAGES = (2.0, 4.0, 6.0, 8.0, 10.0)
"""Commands on both drives [V], half a second each."""

FORCES = tuple(np.geomspace(2.0, 80.0, 10).tolist())
"""Forces of the knocks, 30 ms each [N]."""

CAMERA = 0.19e-3
"""What the vision system errs by [m]."""

_PERIOD, _INTERVALS, _ON = 2e-3, 600, 250
_RING, _KNOCK = 1500, 15


class Validity(NamedTuple):
    """Errors of the linear model and shares of sticking."""

    error: Float[np.ndarray, "tensions heights voltages"]
    """Largest difference of the end-effector's position to the nonlinear model's [m]."""
    lag: Float[np.ndarray, "tensions heights voltages"]
    """Largest distance of the end-effector from the lower carriage, nonlinear [m]."""
    acceleration: Float[np.ndarray, " voltages"]
    """Acceleration of the whole robot that the command asks for [m/s²]."""
    sticking: Float[np.ndarray, "tensions forces 2"]
    """Share of the three seconds after a knock in which the lower and the upper carriage
    rest, at mid-height [1]."""
    threshold: Float[np.ndarray, " tensions"]
    """Deflection of the end-effector up to which friction holds both carriages [m]."""


@functools.cache
def validity() -> Validity:
    """The linear against the nonlinear model, both with exact friction of 4.5 N.

    Returns:
        Errors and shares.
    """
    tension, height, voltage = np.meshgrid(TENSIONS, HEIGHTS, VOLTAGES, indexing="ij")
    flat = (jnp.asarray(part.ravel()) for part in (tension, height, voltage))
    error, lag = (np.asarray(p).reshape(tension.shape) for p in _compared(*flat))
    knocked, force = np.meshgrid(TENSIONS, FORCES, indexing="ij")
    sticking = _sticking(jnp.asarray(knocked.ravel()), jnp.asarray(force.ravel()))
    robot = consistent()
    torque = np.asarray(motor_torque(robot.drive, jnp.asarray(VOLTAGES)))
    moving = float(jnp.sum(masses(robot)[jnp.asarray([0, 2, 3])]))
    force_of_drives = 2 * torque / float(robot.drive.effective_radius)
    return Validity(
        error,
        lag,
        force_of_drives / moving,
        np.asarray(sticking).reshape(*knocked.shape, 2),
        np.array([stick_threshold(t) for t in TENSIONS]),
    )


def stick_threshold(tension: float) -> float:
    r"""Deflection at mid-height up to which friction holds both carriages.

    $|\sin\alpha| \le \mu (\cos\alpha + 1)$ for an upright end-effector between aligned
    carriages, so that $\tan(\alpha/2) = \mu$ at the most.

    Args:
        tension: Effective pretension, friction of 4.5 N on each carriage [N].

    Returns:
        Deflection [m].
    """
    robot = with_tension(consistent(), tension, 0.0)
    angle = 2 * np.arctan(float(robot.lower_carriage.friction.coefficient))
    below = float(robot.frame.height) / 2 - float(robot.end_effector.lower_offset)
    return below * float(np.tan(angle))


@eqx.filter_jit
def _compared(
    tension: Float[Array, " runs"],
    height: Float[Array, " runs"],
    voltage: Float[Array, " runs"],
) -> tuple[Float[Array, " runs"], Float[Array, " runs"]]:
    def one(
        pull: Float[Array, ""], y: Float[Array, ""], volts: Float[Array, ""]
    ) -> tuple[Float[Array, ""], Float[Array, ""]]:
        robot = with_tension(consistent(), pull, 0.0)
        here = jnp.asarray(0.2)
        start = rest(robot, here, here, y)
        on = jnp.where(jnp.arange(_INTERVALS) < _ON, volts, 0.0)
        command = jnp.stack([on, on], axis=1)
        inputs = Inputs(jnp.full(_INTERVALS, _PERIOD), command, jnp.zeros(_INTERVALS))
        true = simulate(robot, start, inputs).position
        linear = simulate_linear(
            robot, start, height=y, interval=jnp.asarray(_PERIOD), voltage=command
        ).position
        error = jnp.hypot(*pose(true - linear).T)
        return jnp.max(error), jnp.max(jnp.abs(true[:, X] - true[:, LOWER]))

    return jax.vmap(one)(tension, height, voltage)


@eqx.filter_jit
def _sticking(
    tension: Float[Array, " runs"], force: Float[Array, " runs"]
) -> Float[Array, "runs 2"]:
    def one(pull: Float[Array, ""], push: Float[Array, ""]) -> Float[Array, "2"]:
        robot = with_tension(consistent(), pull, 0.0)
        here = jnp.asarray(1.1)
        inputs = Inputs(
            jnp.full(_RING, _PERIOD),
            jnp.zeros((_RING, 2)),
            jnp.where(jnp.arange(_RING) < _KNOCK, push, 0.0),
        )
        start = rest(robot, here, here, robot.frame.height / 2)
        velocity = carriages(simulate(robot, start, inputs).velocity[_KNOCK:])
        # The engine's sticking carriages have a velocity of exactly zero.
        return jnp.mean((velocity == 0).astype(velocity.dtype), axis=0)

    return jax.vmap(one)(tension, force)
