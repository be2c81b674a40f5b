"""diffrax on smoothed friction as a contender, for both models.

The commands are given as their two constant stretches, so that no solver looks anything up
on a fine grid.
"""

from collections.abc import Callable

import diffrax
import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from experiments.benchmarks.peers.contender import Contender
from experiments.benchmarks.peers.smoothed_robot import WIDTH
from experiments.benchmarks.problem import (
    DURATION,
    HEIGHT,
    LOG,
    ROWS,
    TORQUE_STEP,
    robot_of,
    start_of,
)
from scdpr_jax.engines.adaptive import Adaptive, simulate_smooth
from scdpr_jax.engines.stepping import friction_coefficients
from scdpr_jax.linear.model import linearise
from scdpr_jax.robot.dynamics import masses
from scdpr_jax.robot.parameters import Robot, smoothed

_SWITCH = DURATION / 2


class Smoothed(Contender):
    """An adaptive solver on the nonlinear model, through `scdpr_jax.engines.adaptive`."""

    solver: diffrax.AbstractSolver = eqx.field(static=True)
    """The method."""
    rtol: float = eqx.field(static=True)
    """Relative tolerance; the absolute one is a hundredth."""
    adjoint: diffrax.AbstractAdjoint = eqx.field(
        static=True, default=diffrax.RecursiveCheckpointAdjoint()
    )
    """How it is differentiated."""

    def __call__(self, values: Float[Array, "4"]) -> Float[Array, "rows 5"]:
        robot = robot_of(values)
        states = simulate_smooth(
            smoothed(robot, width=WIDTH),
            start_of(robot),
            voltage=jnp.asarray(TORQUE_STEP[:: ROWS // 2]),
            times=jnp.array([0.0, _SWITCH, DURATION]),
            save_at=LOG * jnp.arange(ROWS + 1.0),
            method=Adaptive(
                self.solver,
                self.rtol,
                self.rtol / 100,
                max_steps=1_000_000,
                adjoint=self.adjoint,
            ),
        )
        return states.position


class SmoothedLinear(Contender):
    """An adaptive solver on the linear model."""

    solver: diffrax.AbstractSolver = eqx.field(static=True)
    """The method."""
    rtol: float = eqx.field(static=True)
    """Relative tolerance; the absolute one is a hundredth."""
    adjoint: diffrax.AbstractAdjoint = eqx.field(
        static=True, default_factory=diffrax.RecursiveCheckpointAdjoint
    )
    """How it is differentiated."""

    def __call__(self, values: Float[Array, "4"]) -> Float[Array, "rows 5"]:
        robot = robot_of(values)
        start = start_of(robot)
        pid = diffrax.PIDController(rtol=self.rtol, atol=self.rtol / 100)
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(_linear_field(robot)),
            self.solver,
            t0=0.0,
            t1=DURATION,
            dt0=None,
            y0=jnp.concatenate([start.position, start.velocity]),
            saveat=diffrax.SaveAt(ts=LOG * jnp.arange(ROWS + 1.0)),
            stepsize_controller=diffrax.ClipStepSizeController(
                pid, jump_ts=jnp.array([_SWITCH])
            ),
            max_steps=1_000_000,
            adjoint=self.adjoint,
        )
        return solution.ys[:, :5]


def _linear_field(
    robot: Robot,
) -> Callable[[Float[Array, ""], Float[Array, "10"], None], Float[Array, "10"]]:
    r"""$\dot x = A (x - x_0) + B u - 4 T \mu \tanh(v / v_s) / m$."""
    aligned = jnp.zeros(5).at[4].set(HEIGHT)
    space = linearise(robot, aligned)
    limit = 4 * robot.cable.effective_pretension * friction_coefficients(robot)
    limit = limit / masses(robot)[2:4]
    offset = jnp.concatenate([aligned, jnp.zeros(5)])
    pushed = space.input_matrix[:, :2] @ jnp.asarray(TORQUE_STEP[0])

    def field(time: Float[Array, ""], state: Float[Array, "10"], _: None) -> Float[Array, "10"]:
        moved = space.state_matrix @ (state - offset) + jnp.where(time < _SWITCH, pushed, 0.0)
        return moved.at[7:9].add(-limit * jnp.tanh(state[7:9] / WIDTH))

    return field
