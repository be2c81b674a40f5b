"""A run of the virtual rig: the robot under commands or control, and the camera's film of it.

The engine takes `SUBSTEPS` steps in a sample period, four times what a fit takes, so that a fit
can't share its error. Every run is `ROWS` samples long, so that one program serves all.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.sensors import Camera, Encoder, frame_times, observe
from scdpr_jax.engines.closed_loop import pulley_angles, sampled_loop
from scdpr_jax.engines.stepping import Inputs, interpolate, simulate, step
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import State

PERIOD = 1e-3
"""Sample period of the rig's controller [s], section 4.1."""

COUNTS_PER_REV = 26624.0
"""256 pulses, four edges each, gearbox 26:1: counts of one turn of a driver pulley."""

SUBSTEPS = 4
"""Steps of the engine in one sample period, so that a fit can't share its error."""

ROWS = 5400
"""Samples of every simulation, so that it compiles once; runs are cut to their length."""


class Simulated(NamedTuple):
    """A run over all `ROWS`, of which the rig logs the first."""

    states: State
    """State at each sample."""
    angle: Float[Array, "rows 2"]
    """Angles of the driver pulleys from the start [rad]."""
    voltage: Float[Array, "rows 2"]
    """Commands of both drives, each held until the next sample [V]."""


@eqx.filter_jit
def film(
    states: State, first: Float[Array, ""], key: Array
) -> tuple[Float[Array, " frames"], Float[Array, "frames 5"]]:
    """Stamps and frames of the camera over a whole simulation.

    Args:
        states: The run.
        first: Time of the first frame [s].
        key: Of the jitter and the noise.

    Returns:
        Stamps [s], and what the camera sees of the coordinates [m, rad].
    """
    when, noise = jax.random.split(key)
    camera = Camera(jitter=5e-4)
    count = int(ROWS * PERIOD * 30) - 1
    stamps = first + frame_times(camera, count=count, key=when)
    interval = jnp.clip((stamps / PERIOD).astype(int), 0, ROWS - 2)
    inputs = Inputs(jnp.full(ROWS - 1, PERIOD), jnp.zeros((ROWS - 1, 2)), 0.0)
    positions = interpolate(
        states, inputs, interval=interval, fraction=stamps / PERIOD - interval.astype(float)
    )
    return stamps, observe(camera, positions, key=noise)


def _fine(robot: Robot, state: State, held: Inputs) -> State:
    """The state after one sample period, in `SUBSTEPS` steps."""
    part = eqx.tree_at(lambda inputs: inputs.duration, held, held.duration / SUBSTEPS)
    following, _ = jax.lax.scan(
        lambda before, _: (step(robot, before, part), None), state, length=SUBSTEPS
    )
    return following


@eqx.filter_jit
def closed_loop(
    robot: Robot,
    start: State,
    reference: Float[Array, "rows 2"],
    knock: Float[Array, " rows-1"],
) -> Simulated:
    """The robot under the paper's PD.

    Args:
        robot: The rig's robot.
        start: Where it begins.
        reference: Position that the end-effector is to follow [m].
        knock: Force on the end-effector between the samples [N].

    Returns:
        The run.
    """
    run = sampled_loop(
        _fine,
        robot,
        start,
        published_pd(),
        reference=reference,
        knock=knock,
        encoder=Encoder(COUNTS_PER_REV),
        delay_samples=0,
    )
    voltage = jnp.concatenate([run.voltage, run.voltage[-1:]])
    return Simulated(run.states, _angles(robot, run.states), voltage)


@eqx.filter_jit
def _simulate(robot: Robot, start: State, inputs: Inputs) -> Simulated:
    fine = jax.tree.map(lambda leaf: jnp.repeat(leaf, SUBSTEPS, axis=0), inputs)
    fine = eqx.tree_at(lambda i: i.duration, fine, fine.duration / SUBSTEPS)
    states = jax.tree.map(lambda leaf: leaf[::SUBSTEPS], simulate(robot, start, fine))
    return Simulated(states, _angles(robot, states), inputs.voltage)


def _angles(robot: Robot, states: State) -> Float[Array, "rows 2"]:
    start = jax.tree.map(lambda leaf: leaf[0], states)
    return jax.vmap(lambda state: pulley_angles(robot, state, start))(states)


def open_loop(
    robot: Robot,
    start: State,
    voltage: Float[np.ndarray, "rows 2"],
    knock: Float[np.ndarray, " instants"] | None = None,
) -> Simulated:
    """The robot under given commands, zero volts once they end.

    Args:
        robot: The rig's robot.
        start: Where it begins.
        voltage: Commands of both drives [V].
        knock: Force on the end-effector [N]; None for none.

    Returns:
        The run.
    """
    commands = np.zeros((ROWS - 1, 2))
    commands[: voltage.shape[0]] = voltage[: ROWS - 1]
    pushed = np.zeros(ROWS - 1) if knock is None else knock[: ROWS - 1]
    return _simulate(robot, start, Inputs(np.full(ROWS - 1, PERIOD), commands, pushed))
