"""Gains and shapers optimised through the simulated closed loop.

What is found belongs to the manoeuvres it was found on. Friction holds a vibration of up to
some 15 mm for good, and where in it a carriage sticks depends on everything before: a design
that cuts what is left by half and more at the leg times that it was made for leaves other
leg times about as they were. No shaper was found that does better over a family of them.

Landing without vibration is no smooth problem, and the loss has many minima. A search by
sampling (cross entropy) finds a valley, the gradient through the simulation (Adam) goes down
in it.
"""

import functools
from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax
import jax.flatten_util
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.shaper import ShapedTrajectory, Shaper
from scdpr_jax.command.trajectory import Manoeuvre, rest_to_rest
from scdpr_jax.engines.closed_loop import ClosedLoop, closed_loop
from scdpr_jax.robot.dynamics import rest
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot, replace
from tuning.gains.objectives import Scores, loss, score
from tuning.loop.admissible import Admissible

LONGEST_GAP = 0.25
"""Longest time between two impulses that is searched [s]."""
LEG_TIMES = (2.0, 4.0)
"""Times of a leg that are optimised for [s]: what the rigs run the horizontal manoeuvre of
Table 3 with (only that gives the paper's 50 mm), and what the table's letter says."""
TENSIONS = (1.0, 0.99, 1.01)
"""Shares of the effective pretension that a design is tried at [1], the first as fitted."""
WEIGHTS = np.array([0.5, 0.25, 0.25])
"""How much each of them counts [1]."""
IMPULSES = 4
"""Impulses of an optimised shaper."""
LANES = 96
"""Manoeuvres simulated side by side."""
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
    """Logits of crossover and phase margin within what is admissible [1]."""
    gaps: Float[Array, "... gaps"]
    """Logits of the times between the impulses within `LONGEST_GAP` [1]."""
    amplitudes: Float[Array, "... gaps"]
    """Logarithms of all amplitudes but the last over the last one [1]."""


class Effort(NamedTuple):
    """How much is spent on a search."""

    population: int = 32
    """Designs of a generation."""
    generations: int = 12
    """Generations."""
    descents: int = 8
    """Steps of gradient descent that follow."""


def controller_of(within: Admissible, design: Design) -> PD:
    """The controller of a design, at its own period.

    Args:
        within: Which gains are admissible.
        design: The design.

    Returns:
        The controller.
    """
    return within.controller(jax.nn.sigmoid(design.loop))


def shaper_of(design: Design) -> Shaper:
    """The shaper of a design: all its amplitudes are positive, and their sum is 1.

    A positive shaper never asks for more speed or acceleration than the reference did.

    Args:
        design: The design.

    Returns:
        The impulses, the first at 0.
    """
    gaps = LONGEST_GAP * jax.nn.sigmoid(design.gaps)
    times = jnp.concatenate([jnp.zeros(1, gaps.dtype), jnp.cumsum(gaps)])
    logits = jnp.concatenate([design.amplitudes, jnp.zeros(1, gaps.dtype)])
    return Shaper(times, jax.nn.softmax(logits))


def unshaped(impulses: int = 1) -> Shaper:
    """The shaper that changes nothing: one impulse at once.

    Args:
        impulses: Its impulses, all but the first without amplitude.

    Returns:
        The shaper.
    """
    return Shaper(jnp.zeros(impulses), jnp.zeros(impulses).at[0].set(1.0))


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
        shaper: The impulses, applied to the manoeuvre as a whole.
        leg_time: Time of a leg [s].
        samples: Samples at the controller's period, beyond the manoeuvre's end.

    Returns:
        The run, its references and its metrics.
    """
    time = controller.period * jnp.arange(samples, dtype=controller.period.dtype)
    out = rest_to_rest(task.start, task.turn, duration=leg_time)
    back = rest_to_rest(task.turn, task.start, duration=leg_time)
    manoeuvre = Manoeuvre((out, back), 0.0)
    shaped = ShapedTrajectory(manoeuvre, shaper)
    reference = jax.vmap(manoeuvre.position)(time)
    commanded = jax.vmap(shaped.position)(time)
    begin = rest(task.robot, task.start[0], task.start[0], task.start[1])
    run = closed_loop(task.robot, begin, controller, reference=commanded)
    found = score(
        task.robot,
        run,
        commanded=commanded,
        reference=reference,
        end=2 * leg_time + shaper.duration,
    )
    return Tracked(run, reference, commanded, found)


class Optimum(NamedTuple):
    """Where an optimisation ended."""

    controller: PD
    """Gains at the controller's own period."""
    shaper: Shaper
    """The shaper."""
    loss: float
    """Loss, summed over the manoeuvres [1]."""
    unshaped_loss: float
    """Loss of the PD of Eq. (25) alone [1]."""


class _Search(NamedTuple):
    """A normal distribution over flat designs, and the best design seen."""

    mean: Float[np.ndarray, " n"]
    spread: Float[np.ndarray, "n n"]
    best: Float[np.ndarray, " n"]
    loss: float


def optimise(
    task: Task,
    within: Admissible,
    *,
    impulses: int = IMPULSES,
    leg_times: tuple[float, ...] = LEG_TIMES,
    effort: Effort = Effort(),  # noqa: B008 - a frozen tuple
    seed: int = 0,
    progress: Progress = lambda doing, share: None,
) -> Optimum:
    """Gains and a shaper for a cell, through the simulated closed loop.

    Args:
        task: The robot and the manoeuvre's poses.
        within: Which gains are admissible.
        impulses: Impulses of the shaper, two at least.
        leg_times: Times of a leg that the same shaper is to serve [s].
        effort: How much is spent.
        seed: Of the search's random numbers; the same seed finds the same design.
        progress: Told what is being done and which share of it is done.

    Returns:
        The best design seen.
    """
    around = _around(task)
    baseline = {leg: runs(around, alone(), unshaped(impulses), leg) for leg in leg_times}
    template, unflatten = jax.flatten_util.ravel_pytree(_first(impulses))

    def population_losses(
        designs: Float[np.ndarray, "population n"],
    ) -> Float[np.ndarray, " population"]:
        """Mean loss of each design, the pretension as fitted counting half."""
        design = jax.vmap(unflatten)(jnp.asarray(designs))
        pds = jax.vmap(lambda d: _at(COARSE_PERIOD, controller_of(within, d)))(design)
        shapers = jax.vmap(shaper_of)(design)
        crossed = len(designs), len(TENSIONS)
        lanes = jax.tree.map(lambda leaf: jnp.repeat(leaf, crossed[1], axis=0), (pds, shapers))
        tasks = jax.tree.map(lambda leaf: jnp.concatenate([leaf] * crossed[0]), around)
        total = np.zeros(crossed[0])
        for leg, before in baseline.items():
            after = runs(tasks, *lanes, leg)
            each = losses(jax.tree.map(lambda leaf: leaf.reshape(crossed), after), before)
            total += np.asarray(each) @ WEIGHTS / len(baseline)
        return total

    search = _Search(np.asarray(template), _widths(impulses), np.asarray(template), np.inf)
    random = np.random.default_rng(seed)
    for generation in range(effort.generations):
        progress("gains and shaper: search", generation / effort.generations)
        designs = random.multivariate_normal(search.mean, search.spread, effort.population)
        designs[0] = search.best
        search = _learn(search, designs, population_losses(designs))
    best, least = search.best, search.loss
    if effort.descents:
        fitted = tuple(jax.tree.map(lambda leaf: leaf[0], b) for b in baseline.values())

        def slope(flat: Float[Array, " n"]) -> tuple[Float[Array, ""], Float[Array, " n"]]:
            return _slope(
                flat, task, within, fitted, impulses=impulses, leg_times=tuple(leg_times)
            )

        descended = _descend(slope, jnp.asarray(best), effort.descents, progress)
        candidates = np.stack([best, descended])
        tried = population_losses(np.resize(candidates, (effort.population, best.size)))[:2]
        best, least = candidates[np.argmin(tried)], float(np.min(tried))
    design = unflatten(jnp.asarray(best))
    before = [np.asarray(losses(scores, scores)) @ WEIGHTS for scores in baseline.values()]
    return Optimum(
        controller_of(within, design),
        shaper_of(design),
        float(least),
        float(np.mean(before)),
    )


@jax.jit
def losses(found: Scores, baseline: Scores) -> Float[Array, "..."]:
    """Losses of many runs.

    Args:
        found: Metrics of the runs, in any shape.
        baseline: Metrics of Eq. (25)'s PD alone, in a shape that broadcasts to theirs.

    Returns:
        The loss of each, see `tuning.gains.objectives.loss`.
    """
    shape = found.residual_vibration.shape
    flat, against = (
        jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, shape).reshape(-1), scores)
        for scores in (found, baseline)
    )
    return jax.vmap(loss)(flat, against).reshape(shape)


def runs(tasks: Task, controllers: PD, shapers: Shaper, leg_time: float) -> Scores:
    """Metrics of many manoeuvres at the search's period.

    They are run in chunks of `LANES`, so that each leg time is compiled once.

    Args:
        tasks: Robots and poses, one for each run.
        controllers: Controllers at `COARSE_PERIOD`, one for each run or a single one.
        shapers: Shapers, likewise.
        leg_time: Time of a leg [s].

    Returns:
        The metrics of each run.
    """
    count = tasks.start.shape[0]

    def spread(leaf: Array, single: int) -> Array:
        every = leaf if leaf.ndim > single else jnp.broadcast_to(leaf, (count, *leaf.shape))
        return jnp.concatenate([every, jnp.repeat(every[:1], -count % LANES, axis=0)])

    lanes = (
        jax.tree.map(
            lambda leaf: jnp.concatenate([leaf, jnp.repeat(leaf[:1], -count % LANES, axis=0)]),
            tasks,
        ),
        jax.tree.map(lambda leaf: spread(leaf, 0), controllers),
        jax.tree.map(lambda leaf: spread(leaf, 1), shapers),
    )
    found = []
    for first in range(0, count, LANES):
        chunk = jax.tree.map(lambda leaf, first=first: leaf[first : first + LANES], lanes)
        found.append(_chunk(*chunk, leg_time))
    return jax.tree.map(lambda *parts: jnp.concatenate(parts)[:count], *found)


@functools.partial(jax.jit, static_argnames="leg_time")
def _chunk(tasks: Task, controllers: PD, shapers: Shaper, leg_time: float) -> Scores:
    samples, leg = samples_for(leg_time, COARSE_PERIOD), jnp.asarray(leg_time)
    return jax.vmap(lambda *lane: track(*lane, leg, samples=samples).scores)(
        tasks, controllers, shapers
    )


def alone() -> PD:
    """The PD of Eq. (25) at the search's period.

    Returns:
        The controller.
    """
    return _at(COARSE_PERIOD, published_pd())


def _at(period: float, controller: PD) -> PD:
    return PD(controller.proportional_gain, controller.derivative_gain, period)


def samples_for(leg_time: float, period: float) -> int:
    """Samples of a manoeuvre with the longest shaper and `HOLD` after it.

    Args:
        leg_time: Time of a leg [s].
        period: Sample period [s].

    Returns:
        Their number.
    """
    return round((2 * leg_time + 3 * LONGEST_GAP + HOLD) / period) + 1


def _around(task: Task) -> Task:
    """The task at each of `TENSIONS`, stacked."""
    tension = task.robot.cable.effective_pretension * jnp.asarray(TENSIONS)
    robots = jax.vmap(lambda t: replace(task.robot, {"effective_pretension": t}))(tension)
    copies = jnp.ones((len(TENSIONS), 1))
    return Task(robots, copies * task.start[None], copies * task.turn[None])


def _first(impulses: int) -> Design:
    return Design(
        loop=jnp.zeros(2),
        gaps=jnp.zeros(impulses - 1),
        amplitudes=jnp.zeros(impulses - 1),
    )


def _widths(impulses: int) -> Float[np.ndarray, "n n"]:
    """Spread of the first generation: logits over most of their range."""
    widths = np.concatenate(
        [np.full(2, 0.8), np.full(impulses - 1, 1.2), np.full(impulses - 1, 1.0)]
    )
    return np.diag(np.square(widths))


def _learn(
    search: _Search,
    designs: Float[np.ndarray, "population n"],
    losses: Float[np.ndarray, " population"],
) -> _Search:
    """The distribution moved to a generation's best quarter, as in cross entropy."""
    losses = np.where(np.isfinite(losses), losses, np.inf)
    order = np.argsort(losses)
    elite = designs[order[: max(len(order) // 4, 2)]]
    weights = np.log(len(elite) + 0.5) - np.log(np.arange(1, len(elite) + 1))
    weights /= weights.sum()
    away = elite - search.mean
    spread = (away * weights[:, None]).T @ away
    better = losses[order[0]] < search.loss
    return _Search(
        mean=0.3 * search.mean + 0.7 * (weights @ elite),
        spread=0.5 * (search.spread + spread) + 1e-5 * np.eye(len(search.mean)),
        best=designs[order[0]] if better else search.best,
        loss=float(losses[order[0]]) if better else search.loss,
    )


@functools.partial(jax.jit, static_argnames=("impulses", "leg_times"))
def _slope(
    flat: Float[Array, " n"],
    task: Task,
    within: Admissible,
    baseline: tuple[Scores, ...],
    *,
    impulses: int,
    leg_times: tuple[float, ...],
) -> tuple[Float[Array, ""], Float[Array, " n"]]:
    """Mean loss of a design at the pretension as fitted, and its gradient.

    Forward mode: there are a handful of numbers, and nothing of the run is stored.
    """
    _, unflatten = jax.flatten_util.ravel_pytree(_first(impulses))

    def total(flat: Float[Array, " n"]) -> Float[Array, ""]:
        design = unflatten(flat)
        pd, shaper = _at(COARSE_PERIOD, controller_of(within, design)), shaper_of(design)
        each = []
        for leg, before in zip(leg_times, baseline, strict=True):
            samples = samples_for(leg, COARSE_PERIOD)
            after = track(task, pd, shaper, jnp.asarray(leg), samples=samples).scores
            each.append(loss(after, before))
        return sum(each) / len(each)

    along = functools.partial(jax.jvp, total, (flat,))
    basis = jnp.eye(flat.size, dtype=flat.dtype)
    values, slopes = jax.vmap(lambda direction: along((direction,)))(basis)
    return values[0], slopes


def _descend(
    slope: Callable[[Float[Array, " n"]], tuple[Float[Array, ""], Float[Array, " n"]]],
    point: Float[Array, " n"],
    steps: int,
    progress: Progress,
) -> Float[np.ndarray, " n"]:
    """Adam from a point, keeping the best: a step over a sticking instant may lose."""
    optimiser = optax.chain(optax.clip_by_global_norm(1.0), optax.adam(1e-2))
    memory = optimiser.init(point)
    best, least = point, np.inf
    for number in range(steps):
        progress("gains and shaper: descent", number / steps)
        value, gradient = slope(point)
        if float(value) < least:
            best, least = point, float(value)
        # Adam's bias correction mixes a float with a counter, which strict promotion refuses.
        with jax.numpy_dtype_promotion("standard"):
            change, memory = optimiser.update(gradient, memory, point)
        point = optax.apply_updates(point, change)
    return np.asarray(best)
