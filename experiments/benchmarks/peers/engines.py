"""This project's two engines as contenders, and what XLA makes of the same step."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from experiments.benchmarks.peers.contender import Contender
from experiments.benchmarks.problem import (
    HEIGHT,
    LOG,
    PARTS,
    ROWS,
    TORQUE_STEP,
    robot_of,
    start_of,
)
from scdpr_jax import native
from scdpr_jax.engines import stepping
from scdpr_jax.engines.linear_stepping import simulate_linear
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import State


class LinearEngine(Contender):
    """`scdpr_jax.engines.linear_stepping`."""

    parts: int = eqx.field(static=True, default=PARTS)
    """Steps in an interval of the log."""
    rubbing_drives: bool = eqx.field(static=True, default=False)
    """Whether the drives' dry friction is followed: the problem's drives have none."""

    def __call__(self, values: Float[Array, "4"]) -> Float[Array, "rows 5"]:
        robot = robot_of(values)
        states = simulate_linear(
            robot,
            start_of(robot),
            height=jnp.asarray(HEIGHT, values.dtype),
            interval=jnp.asarray(LOG, values.dtype),
            voltage=jnp.asarray(TORQUE_STEP, values.dtype),
            substeps=self.parts,
            rubbing_drives=self.rubbing_drives,
        )
        return states.position


class NonlinearEngine(Contender):
    """`scdpr_jax.engines.stepping`."""

    parts: int = eqx.field(static=True, default=PARTS)
    """Steps in an interval of the log."""

    def __call__(self, values: Float[Array, "4"]) -> Float[Array, "rows 5"]:
        robot = robot_of(values)
        inputs = stepping.Inputs(
            duration=jnp.full(ROWS, LOG, values.dtype),
            voltage=jnp.asarray(TORQUE_STEP, values.dtype),
            knock=jnp.zeros(ROWS, values.dtype),
        )
        start = start_of(robot)
        return stepping.simulate(robot, start, inputs, substeps=self.parts).position


class ByXla(Contender):
    """The nonlinear engine's own step as an ordinary XLA program, without machine code."""

    parts: int = eqx.field(static=True, default=PARTS)
    """Steps in an interval of the log."""

    def __call__(self, values: Float[Array, "4"]) -> Float[Array, "rows 5"]:
        robot = robot_of(values)
        start = start_of(robot)
        duration = jnp.full(ROWS, LOG / self.parts, values.dtype)
        voltage = jnp.asarray(TORQUE_STEP, values.dtype)
        inputs = stepping.Inputs(duration, voltage, jnp.zeros_like(duration))
        _, states = native.scan(self._advance, robot, start, inputs)
        return jnp.concatenate([start.position[None], states.position])

    def _advance(
        self, robot: Robot, state: State, held: stepping.Inputs
    ) -> tuple[State, State]:
        following = jax.lax.fori_loop(
            0, self.parts, lambda _, now: stepping.step(robot, now, held), state
        )
        return following, following
