"""One leg: a robot run under a command law, and what came of it."""

from collections.abc import Sequence

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.sensors import Encoder
from scdpr_jax.engines.closed_loop import closed_loop
from scdpr_jax.legs.command_law import Commands
from scdpr_jax.legs.measures import LegMeasures, measure
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import State


class Leg(eqx.Module):
    """A leg as it was run: traces at the controller's samples, and its measures."""

    time: Float[Array | np.ndarray, "... samples"] = eqx.field(metadata=si("s", "t"))
    """Times of the samples [s], from 0."""
    reference: Float[Array | np.ndarray, "... samples 2"] = eqx.field(
        metadata=si("m", "x^*, y^*")
    )
    """Where the end-effector was to be, before shaping [m]."""
    commanded: Float[Array | np.ndarray, "... samples 2"] = eqx.field(metadata=si("m"))
    """Reference that the controller was given [m]."""
    states: State
    """States at the samples."""
    voltage: Float[Array | np.ndarray, "... intervals 2"] = eqx.field(metadata=si("V", "V"))
    """Saturated commands held between the samples, one fewer than samples [V]."""
    measures: LegMeasures
    """What it comes to."""

    @property
    def pose(self) -> Float[Array | np.ndarray, "... samples 2"]:
        """Where the end-effector was, $[x_e, y_e]$ [m]."""
        return self.states.pose

    def until(self, samples: int) -> "Leg":
        """The leg's first samples, as NumPy arrays; its measures are the whole leg's.

        Args:
            samples: How many.

        Returns:
            The shorter leg.
        """

        def cut(leaf: Array | np.ndarray) -> np.ndarray:
            return np.asarray(leaf)[:samples]

        return Leg(
            time=cut(self.time),
            reference=cut(self.reference),
            commanded=cut(self.commanded),
            states=jax.tree.map(cut, self.states),
            voltage=cut(self.voltage)[: samples - 1],
            measures=self.measures,
        )


def leg_of(arrays: Sequence[Array | np.ndarray]) -> Leg:
    """A leg of its arrays, in the order of `jax.tree.leaves`.

    That is what a program that is kept (`scdpr_jax.native.kept_jit`) returns of it.

    Args:
        arrays: The arrays.

    Returns:
        The leg.
    """
    time, reference, commanded, position, velocity, voltage, *measures = arrays
    states = State(position, velocity)
    return Leg(time, reference, commanded, states, voltage, LegMeasures(*measures))


def run_leg(
    robot: Robot, start: State, commands: Commands, *, encoder: Encoder | None = None
) -> Leg:
    """A robot under commands, by the nonlinear model with exact friction.

    What of a leg isn't used costs nothing within a compiled function.

    Args:
        robot: The robot, with `Coulomb` friction on both carriages.
        start: Its state at the first sample, at rest.
        commands: What it is told.
        encoder: Encoders that the angles are read by; `None` for exact angles.

    Returns:
        The leg.
    """
    run = closed_loop(
        robot,
        start,
        commands.controller,
        reference=commands.commanded,
        feedforward=commands.feedforward,
        encoder=encoder,
    )
    return Leg(
        time=run.time,
        reference=commands.reference,
        commanded=commands.commanded,
        states=run.states,
        voltage=run.voltage,
        measures=measure(robot, run, commands),
    )
