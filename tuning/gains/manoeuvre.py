"""The horizontal manoeuvre of Table 3, out and back under control: one, and many at once."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PyTree

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.command.trajectory import Manoeuvre, rest_to_rest
from scdpr_jax.legs.command_law import CommandLaw
from scdpr_jax.legs.ensemble import Ensemble
from scdpr_jax.legs.leg import Leg, run_leg
from scdpr_jax.legs.measures import LegMeasures
from scdpr_jax.native import kept_jit
from scdpr_jax.robot.fields import si
from tuning.gains.design import LONGEST_GAP
from tuning.gains.loss import loss

LANES = 96
"""Manoeuvres simulated side by side."""
HOLD = 1.0
"""Time that is looked at after the slowest manoeuvre [s]: three periods of 3 Hz."""
COARSE_PERIOD = 2e-3
"""Sample period of a search [s]; its result is simulated at the controller's own."""


class Task(eqx.Module):
    """Robots at rest and the manoeuvre that they are tuned on, out and back."""

    ensemble: Ensemble
    """The robots as they are in the cell, where the manoeuvre begins and ends."""
    turn: Float[Array, "... 2"] = eqx.field(metadata=si("m"))
    """Position in between [m]."""


def track(
    task: Task, controller: PD, shaper: Shaper, leg_time: Float[Array, ""], *, samples: int
) -> Leg:
    """A horizontal manoeuvre out and back under control.

    Args:
        task: The robot and the manoeuvre's poses.
        controller: The controller.
        shaper: The impulses, applied to the manoeuvre as a whole.
        leg_time: Time of a leg [s].
        samples: Samples at the controller's period, beyond the manoeuvre's end.

    Returns:
        The run.
    """
    start = task.ensemble.position
    out = rest_to_rest(start, task.turn, duration=leg_time)
    back = rest_to_rest(task.turn, start, duration=leg_time)
    law = CommandLaw(Manoeuvre((out, back), 0.0), controller, shaper)
    return run_leg(task.ensemble.robot, task.ensemble.start, law.commands(samples))


def samples_for(leg_time: float, period: float) -> int:
    """Samples of a manoeuvre with the longest shaper and `HOLD` after it.

    Args:
        leg_time: Time of a leg [s].
        period: Sample period [s].

    Returns:
        Their number.
    """
    return round((2 * leg_time + 3 * LONGEST_GAP + HOLD) / period) + 1


@jax.jit
def losses(measures: LegMeasures, baseline: LegMeasures) -> Float[Array, "..."]:
    """Losses of many runs.

    Args:
        measures: Measures of the runs, in any shape.
        baseline: Those of Eq. (25)'s PD alone, in a shape that broadcasts to theirs.

    Returns:
        The loss of each, see `tuning.gains.loss.loss`.
    """
    shape = measures.residual_vibration.shape
    flat, against = (
        jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, shape).reshape(-1), each)
        for each in (measures, baseline)
    )
    return jax.vmap(loss)(flat, against).reshape(shape)


def runs(tasks: Task, controllers: PD, shapers: Shaper, leg_time: float) -> LegMeasures:
    """Measures of many manoeuvres at the search's period.

    They are run in chunks of `LANES`, so that each leg time is compiled once.

    Args:
        tasks: Robots and poses, one for each run.
        controllers: Controllers at `COARSE_PERIOD`, one for each run or a single one.
        shapers: Shapers, likewise.
        leg_time: Time of a leg [s].

    Returns:
        The measures of each run.
    """
    chunks = _chunks(tasks, controllers, shapers)
    parts = zip(*(_chunk(*chunk, leg_time) for chunk in chunks), strict=True)
    return LegMeasures(*(np.concatenate(part)[: len(tasks.ensemble)] for part in parts))


def compile_runs(tasks: Task, controllers: PD, shapers: Shaper, leg_time: float) -> None:
    """Compiles what `runs` needs for such arguments, of any number.

    Args:
        tasks: Robots and poses.
        controllers: Controllers.
        shapers: Shapers.
        leg_time: Time of a leg [s].
    """
    _chunk.compile(*_chunks(tasks, controllers, shapers)[0], leg_time)


def _chunks(tasks: Task, controllers: PD, shapers: Shaper) -> list[tuple[Task, PD, Shaper]]:
    """Runs in chunks of `LANES`; the last one is filled up with the first run."""
    count = len(tasks.ensemble)
    rows = np.resize(np.arange(count), count + -count % LANES)
    rows[count:] = 0

    def spread(leaf: Array, single: int) -> np.ndarray:
        numbers = np.asarray(leaf)
        return numbers[rows] if leaf.ndim > single else np.stack([numbers] * len(rows))

    lanes = (
        jax.tree.map(lambda leaf: np.asarray(leaf)[rows], tasks),
        jax.tree.map(lambda leaf: spread(leaf, 0), controllers),
        jax.tree.map(lambda leaf: spread(leaf, 1), shapers),
    )
    return [
        jax.tree.map(lambda leaf, first=first: leaf[first : first + LANES], lanes)
        for first in range(0, len(rows), LANES)
    ]


@kept_jit
def _chunk(
    tasks: Task, controllers: PD, shapers: Shaper, leg_time: float
) -> list[Float[Array, " lanes"]]:
    """The fields of `LegMeasures`."""
    samples, leg = samples_for(leg_time, COARSE_PERIOD), jnp.asarray(leg_time)

    def lane(*own: PyTree) -> list[Float[Array, ""]]:
        return jax.tree.leaves(track(*own, leg, samples=samples).measures)

    return jax.vmap(lane)(tasks, controllers, shapers)


def alone() -> PD:
    """The PD of Eq. (25) at the search's period.

    Returns:
        The controller.
    """
    return at_period(COARSE_PERIOD, published_pd())


def at_period(period: float, controller: PD) -> PD:
    """A controller's gains at another sample period.

    Args:
        period: The period [s].
        controller: The controller.

    Returns:
        The controller.
    """
    return PD(controller.proportional_gain, controller.derivative_gain, period)
