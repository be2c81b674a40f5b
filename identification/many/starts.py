"""Where fits of short runs begin: the drives by momentum, the pretension by a scan."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from identification.many.lanes import Task
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.quantities import value

PRETENSIONS = tuple(float(factor) for factor in np.geomspace(0.36, 2.8, 36))
"""Multiples of the start's pretension that are scanned [1]: 6 % apart."""

STANDING = 4.0
"""Travel of the lower carriage in an interval over its encoders' noise, up to which it may
stand [1]."""


LARGEST_SHARE = 5.0
"""Most that the momentum may change a start by, either way [1]: where friction is a small part
of it, the rest of it is taken from the start."""


def balanced(lane: tuple[Task, Float[Array, "4"]]) -> Float[Array, "4"]:
    r"""The start with friction force, inertia and damping by the whole robot's momentum.

    The loop's forces are internal, so that from rest, twice integrated,

    $$ m_e \Delta x_e + m_3 \Delta q_3 + m_4 \Delta q_4
       - \iint \big((\tau_1 + \tau_2)/r + F_k\big)
       = -\tfrac{2J}{r^2} \Delta q_3 - \tfrac{2b}{r^2} \int \Delta q_3
         - F \iint (\mathrm{sgn}\,\dot q_3 + \mathrm{sgn}\,\dot q_4) $$

    linear in J, b and F; the drives' dry friction is taken off their torques. The upper
    carriage is taken to slide as the lower one does, up to where that one stands again: the
    friction that holds it isn't known.
    """
    task, start = lane
    robot, run = task.robot, task.run
    radius = value(robot, "effective_radius")
    weight, measured = run.weight, run.measured - run.measured[:1]
    lower = radius / 2 * (measured[:, 0] + measured[:, 1])
    noise = radius / jnp.sqrt(jnp.sum(jnp.square(weight[0, :2])))
    travel = jnp.diff(lower)
    slides = jnp.abs(travel) > STANDING * noise
    turns = jnp.diff(measured[:, :2], axis=0)
    turning = jnp.abs(turns) * weight[:1, :2] > STANDING
    begun = jnp.cumsum(slides) > 0
    stood = jnp.cumsum(begun & ~slides) > 0

    def integral(rate: Float[Array, " intervals"]) -> Float[Array, " rows"]:
        return task.interval * jnp.concatenate([jnp.zeros_like(rate[:1]), jnp.cumsum(rate)])

    def twice(rate: Float[Array, " intervals"]) -> Float[Array, " rows"]:
        speed = integral(rate)
        return integral((speed[1:] + speed[:-1]) / 2)

    rubbed = robot.drive.frictions[None, :] * jnp.where(turning, jnp.sign(turns), 0.0)
    torque = jnp.sum(motor_torque(robot.drive, run.voltage) - rubbed, axis=1)
    masses = (
        value(robot, f"{name}_mass")
        for name in ("end_effector", "lower_carriage", "upper_carriage")
    )
    moved = (measured[:, 2], lower, measured[:, 5])
    momentum = sum(m * by for m, by in zip(masses, moved, strict=True))
    right = momentum - twice(torque / radius + run.knock)
    columns = jnp.stack(
        [
            -2 * twice(jnp.where(slides, jnp.sign(travel), 0.0)),
            -2 / jnp.square(radius) * lower,
            -2 / jnp.square(radius) * integral((lower[1:] + lower[:-1]) / 2),
        ],
        axis=1,
    )
    used = (weight[:, 2] > 0) & (weight[:, 5] > 0) & ~jnp.concatenate([stood[:1], stood])
    scale = jnp.exp(start[:3])
    system = jnp.where(used[:, None], columns * scale[None, :], 0.0)
    normal = system.T @ system
    # Where too little is seen, a billionth leads to the start itself.
    regular = 1e-9 * jnp.trace(normal) + jnp.finfo(normal.dtype).tiny
    rest = system.T @ (jnp.where(used, right, 0.0) - system @ jnp.ones_like(scale))
    share = 1 + jnp.linalg.solve(normal + regular * jnp.eye(3, dtype=normal.dtype), rest)
    return start.at[:3].add(jnp.log(jnp.clip(share, 1 / LARGEST_SHARE, LARGEST_SHARE)))


def scanned(lane: tuple[Task, Float[Array, "4"]]) -> Float[Array, "4"]:
    """The point with the pretension about it that fits best."""
    task, start = lane

    def misfit(factor: Float[Array, ""]) -> Float[Array, ""]:
        cost = jnp.sum(jnp.square(task.residuals(start.at[3].add(jnp.log(factor)))))
        return jnp.where(jnp.isfinite(cost), cost, jnp.inf)

    factors = jnp.asarray(PRETENSIONS, dtype=start.dtype)
    # A few at a time: the lanes fill the processor, and a call costs as much as a run of one.
    best = factors[jnp.argmin(jax.lax.map(misfit, factors, batch_size=4))]
    return start.at[3].add(jnp.log(best))
