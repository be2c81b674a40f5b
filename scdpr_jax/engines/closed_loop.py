r"""The sampled closed loop of section 6 on the fixed-grid engine.

At sample $t_k$ the encoders are read, the controller runs at once, and its saturated
command is held over $[t_k, t_{k+1}]$; a delay of whole samples can be put between the
controller and the drives. `sampled_loop` is that loop around any integrator.
"""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax import native
from scdpr_jax.command.controller import Controller, saturate
from scdpr_jax.command.sensors import Encoder, read_encoder
from scdpr_jax.engines.arguments import check_finite, check_shape, check_start
from scdpr_jax.engines.stepping import Inputs, step, with_start
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.kinematics import inverse_kinematics
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import State

Advance = Callable[[Robot, State, Inputs], State]
"""State after one interval of held inputs."""


class ClosedLoop(eqx.Module):
    """A run under control: states at the samples and the commands between them."""

    time: Float[Array, "... samples"] = eqx.field(converter=real, metadata=si("s", "t"))
    """Times of the samples [s], from 0."""
    states: State
    """States at the samples."""
    voltage: Float[Array, "... intervals 2"] = eqx.field(converter=real, metadata=si("V", "V"))
    """Saturated commands held between the samples, one fewer than samples [V]."""


def closed_loop(
    robot: Robot,
    start: State,
    controller: Controller,
    *,
    reference: Float[Array, "samples 2"],
    feedforward: Float[Array, "samples 2"] | None = None,
    knock: Float[Array, " samples-1"] | None = None,
    encoder: Encoder | None = None,
    delay_samples: int = 0,
) -> ClosedLoop:
    """The robot under a sampled controller, with exact Coulomb friction.

    One step of `scdpr_jax.engines.stepping` for each sample period.

    Args:
        robot: The robot, with `Coulomb` friction on both carriages.
        start: State at the first sample.
        controller: The controller, run at its own period.
        reference: Commanded end-effector positions $[x_e, y_e]$ at the samples [m]; the
            encoders show zero at the start, and the controller takes it for the first one.
        feedforward: Commands that are added to the controller's at the samples [V]; `None`
            for none.
        knock: Horizontal force on the end-effector, held between the samples [N].
        encoder: Encoders that the angles are read by; `None` for exact angles.
        delay_samples: Whole periods by which a command comes late; 0 V until the first.

    Returns:
        States at the samples and commands between them.

    Raises:
        TypeError: If a carriage has another friction law.
        ValueError: If the delay is negative, a shape is another, or a number isn't finite.
    """
    return sampled_loop(
        step,
        robot,
        start,
        controller,
        reference=reference,
        feedforward=feedforward,
        knock=knock,
        encoder=encoder,
        delay_samples=delay_samples,
    )


def sampled_loop(
    advance: Advance,
    robot: Robot,
    start: State,
    controller: Controller,
    *,
    reference: Float[Array, "samples 2"],
    knock: Float[Array, " samples-1"] | None,
    encoder: Encoder | None,
    delay_samples: int,
    feedforward: Float[Array, "samples 2"] | None = None,
    run: Callable[..., Any] = native.run,
) -> ClosedLoop:
    """The sampled loop around an integrator of one period.

    Args:
        advance: State after one interval of held inputs, of a robot.
        robot: The robot.
        start: State at the first sample.
        controller: The controller.
        reference: Commanded end-effector positions at the samples [m].
        knock: Horizontal force on the end-effector between the samples [N].
        encoder: Encoders that the angles are read by; `None` for exact angles.
        delay_samples: Whole periods by which a command comes late.
        feedforward: Commands that are added to the controller's [V].
        run: How samples follow each other: `native.run`, or `native.scan` around an integrator
            that machine code can't do.

    Returns:
        States at the samples and commands between them.

    Raises:
        ValueError: If the delay is negative, a shape is another, or a number isn't finite.
    """
    if delay_samples < 0:
        raise ValueError(
            f"`delay_samples` must be 0 or more [samples], got {delay_samples}: a command "
            "can't come before its sample."
        )
    _check(robot, start, reference, feedforward, knock)
    period = jnp.asarray(controller.period, dtype=start.position.dtype)
    intervals = reference.shape[0] - 1
    if knock is None:
        knock = jnp.zeros(intervals, dtype=period.dtype)
    if feedforward is None:
        feedforward = jnp.zeros((intervals + 1, 2), dtype=period.dtype)
    references = joint_references(robot, reference)

    loop = _Loop(robot, start, controller, encoder, period, advance)
    memory = controller.initial_state(references[0], loop.measured(start))
    waiting = jnp.zeros((delay_samples, 2), dtype=period.dtype)
    _, (states, voltage) = run(
        _sample, loop, (start, memory, waiting), (references[:-1], feedforward[:-1], knock)
    )
    return ClosedLoop(
        time=period * jnp.arange(intervals + 1, dtype=period.dtype),
        states=with_start(start, states),
        voltage=voltage,
    )


def _check(
    robot: Robot,
    start: State,
    reference: Float[Array, "samples 2"],
    feedforward: Float[Array, "samples 2"] | None,
    knock: Float[Array, " samples-1"] | None,
) -> None:
    """Refuse what can't be a run: one row for each sample, one knock fewer."""
    check_start(robot, start)
    check_shape(reference, ("samples", 2), name="reference", unit="m")
    samples = jnp.shape(reference)[0]
    if samples < 1:
        raise ValueError(
            "`reference` must have one sample at least [m], got none. Its first row is where "
            "the controller is switched on."
        )
    check_finite(reference, name="reference", unit="m")
    if feedforward is not None:
        check_shape(feedforward, (samples, 2), name="feedforward", unit="V")
        check_finite(feedforward, name="feedforward", unit="V")
    if knock is not None:
        check_shape(knock, (samples - 1,), name="knock", unit="N")
        check_finite(knock, name="knock", unit="N")


class _Loop(eqx.Module):
    """What is the same at all samples."""

    robot: Robot
    start: State
    controller: Controller
    encoder: Encoder | None
    period: Float[Array, ""]
    advance: Advance = eqx.field(static=True)

    def measured(self, state: State) -> Float[Array, "2"]:
        """Angles that the controller is told."""
        angles = pulley_angles(self.robot, state, self.start)
        return angles if self.encoder is None else read_encoder(self.encoder, angles)


_Carry = tuple[State, Any, Float[Array, "delay 2"]]
"""State, the controller's memory, and commands that wait."""


def _sample(
    loop: _Loop,
    carry: _Carry,
    given: tuple[Float[Array, "2"], Float[Array, "2"], Float[Array, ""]],
) -> tuple[_Carry, tuple[State, Float[Array, "2"]]]:
    """A sample and the interval behind it."""
    state, memory, waiting = carry
    wanted, forward, push = given
    memory, command = loop.controller.step(memory, wanted, loop.measured(state))
    limited = saturate(command + forward, loop.robot.drive.voltage_limit)
    queue = jnp.concatenate([waiting, limited[None]])
    following = loop.advance(loop.robot, state, Inputs(loop.period, queue[0], push))
    return (following, memory, queue[1:]), (following, queue[0])


def joint_references(
    robot: Robot, reference: Float[Array, "samples 2"]
) -> Float[Array, "samples 2"]:
    """Commanded angles of the driver pulleys, from zero at the first sample, Eq. (3).

    Args:
        robot: The robot.
        reference: Commanded end-effector positions $[x_e, y_e]$ [m].

    Returns:
        Commanded angles [rad].
    """
    to_angles = jax.vmap(inverse_kinematics, in_axes=(0, None))
    return to_angles(reference - reference[:1], robot.drive.effective_radius)


def pulley_angles(robot: Robot, state: State, start: State) -> Float[Array, "2"]:
    r"""Angles of the driver pulleys, which follow the lower carriage and the height.

    $$ \alpha_1 = (\Delta q_3 + \Delta y_e) / r, \qquad
       \alpha_2 = (\Delta q_3 - \Delta y_e) / r $$

    Args:
        robot: The robot.
        state: Its state.
        start: The state where the angles are zero.

    Returns:
        Angles [rad].
    """
    return inverse_kinematics(state.driven - start.driven, robot.drive.effective_radius)
