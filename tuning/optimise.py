"""Gains and shapers optimised through the simulated closed loop.

Landing without vibration is no smooth problem: each carriage sticks at an instant that
depends on everything before it, and the loss has many minima. A search by sampling (cross
entropy) finds a valley, the gradient through the simulation (Adam) goes down in it.
"""

from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float

from scdpr_jax.closed_loop import ClosedLoop, closed_loop
from scdpr_jax.controller import PD, published_pd
from scdpr_jax.drive import drive_gain, drive_pole
from scdpr_jax.dynamics import rest
from scdpr_jax.fields import si
from scdpr_jax.parameters import Robot
from scdpr_jax.shaper import Shaper
from tuning.loop_shaping import shape_sampled_loop
from tuning.objectives import Scores, loss, score
from tuning.plant import MotorPlant
from tuning.shaped_legs import there_and_back

CROSSOVERS = (25.0, 80.0)
"""Gain crossovers that are searched [rad/s]; Eq. (25) asks for 40."""
PHASE_MARGINS = (np.deg2rad(45.0), np.deg2rad(75.0))
"""Phase margins of the sampled loop that are searched [rad]; Eq. (25) asks for 60°."""
LONGEST_GAP = 0.25
"""Longest time between two impulses that is searched [s]."""
LEG_TIMES = (2.0, 4.0)
"""Times of a leg [s]: as the rigs run the horizontal manoeuvre, and as Table 3 prints it."""
HOLD = 1.0
"""Time that is looked at after the slowest manoeuvre [s]: three periods of 3 Hz."""
COARSE_PERIOD = 2e-3
"""Sample period of the search [s]; the result is simulated at the controller's own."""

Progress = Callable[[str, float], None]
"""Told what is being done and which share of it is done, 0 to 1."""


class Task(eqx.Module):
    """A robot and the pose that a horizontal manoeuvre is tuned at."""

    robot: Robot
    """The robot as it is in the cell."""
    start: Float[Array, "... 2"] = eqx.field(metadata=si("m"))
    """First and last position of the manoeuvre [m]."""
    turn: Float[Array, "... 2"] = eqx.field(metadata=si("m"))
    """Position in between [m]."""


class Design(eqx.Module):
    """Gains and a shaper as unconstrained numbers: whatever they are, both are sensible."""

    loop: Float[Array, "... 2"]
    """Logits of crossover and phase margin within what is searched [1]."""
    gaps: Float[Array, "... impulses-1"]
    """Logits of the times between the impulses within `LONGEST_GAP` [1]."""
    amplitudes: Float[Array, "... impulses-1"]
    """All amplitudes but the last, which makes their sum 1 [1]."""


class Effort(NamedTuple):
    """How much is spent on a search."""

    population: int = 48
    """Designs of a generation."""
    generations: int = 16
    """Generations."""
    descents: int = 0
    """Steps of gradient descent that follow."""




def controller_of(robot: Robot, design: Design, *, period: float = 1e-3) -> PD:
    """The controller of a design, with its crossover and margin exactly when sampled.

    Args:
        robot: The robot.
        design: The design.
        period: Sample period [s].

    Returns:
        The controller.
    """
    share = jax.nn.sigmoid(design.loop)
    crossover = CROSSOVERS[0] + (CROSSOVERS[1] - CROSSOVERS[0]) * share[0]
    margin = PHASE_MARGINS[0] + (PHASE_MARGINS[1] - PHASE_MARGINS[0]) * share[1]
    plant = MotorPlant(gain=drive_gain(robot.drive), pole=drive_pole(robot.drive))
    return shape_sampled_loop(plant, crossover=crossover, phase_margin=margin, period=period)


def shaper_of(design: Design) -> Shaper:
    """The shaper of a design.

    Args:
        design: The design.

    Returns:
        The impulses, the first at 0.
    """
    gaps = LONGEST_GAP * jax.nn.sigmoid(design.gaps)
    times = jnp.concatenate([jnp.zeros(1, gaps.dtype), jnp.cumsum(gaps)])
    last = 1 - jnp.sum(design.amplitudes, keepdims=True)
    return Shaper(times, jnp.concatenate([design.amplitudes, last]))


def unshaped() -> Shaper:
    """The shaper that changes nothing: one impulse at once.

    Returns:
        The shaper.
    """
    return Shaper(jnp.zeros(1), jnp.ones(1))


class Tracked(NamedTuple):
    """A manoeuvre that was run."""

    run: ClosedLoop
    reference: Float[Array, "samples 2"]
    commanded: Float[Array, "samples 2"]
    scores: Scores


def track(
    task: Task, controller: PD, shaper: Shaper, leg_time: Float[Array, ""], *, samples: int
) -> Tracked:
    """A horizontal manoeuvre out and back under control, and its metrics.

    Args:
        task: The robot and the manoeuvre's poses.
        controller: The controller.
        shaper: The impulses, applied to each leg within its time.
        leg_time: Time of a leg [s].
        samples: Samples at the controller's period, beyond the manoeuvre's end.

    Returns:
        The run, its references and its metrics.
    """
    time = controller.period * jnp.arange(samples, dtype=controller.period.dtype)
    poses = {"start": task.start, "end": task.turn, "leg_time": leg_time}
    manoeuvre = there_and_back(**poses, shaper=shaper)
    reference = jax.vmap(there_and_back(**poses, shaper=unshaped()).position)(time)
    commanded = jax.vmap(manoeuvre.position)(time)
    begin = rest(task.robot, task.start[0], task.start[0], task.start[1])
    run = closed_loop(task.robot, begin, controller, reference=commanded)
    found = score(
        task.robot, run, commanded=commanded, reference=reference, end=manoeuvre.duration
    )
    return Tracked(run, reference, commanded, found)
