"""Gains and shapers optimised through the simulated closed loop.

What is found belongs to the manoeuvres it was found on. Friction holds a vibration of up to
some 15 mm for good, and where in it a carriage sticks depends on everything before: a design
that cuts what is left by half and more at the leg times that it was made for leaves other
leg times about as they were. No shaper was found that does better over a family of them.

Landing without vibration is no smooth problem, and the loss has many minima. A search by
sampling (cross entropy) finds a valley, the gradient through the simulation (Adam) goes down
in it.
"""

import dataclasses
import functools
from collections.abc import Callable, Iterator
from typing import NamedTuple

import jax
import jax.flatten_util
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.legs.command_law import unshaped
from scdpr_jax.legs.ensemble import Variation, varied
from scdpr_jax.legs.measures import LegMeasures
from scdpr_jax.native import kept_jit
from scdpr_jax.numerics.progress import SILENT, Progress
from tuning.gains.cross_entropy import cross_entropy
from tuning.gains.design import IMPULSES, controller_of, middle, shaper_of, spread_of
from tuning.gains.loss import loss
from tuning.gains.manoeuvre import (
    COARSE_PERIOD,
    Task,
    alone,
    at_period,
    compile_runs,
    losses,
    runs,
    samples_for,
    track,
)
from tuning.loop.admissible import Admissible, any_bounds

LEG_TIMES = (2.0, 4.0)
"""Times of a leg that are optimised for [s]: what the rigs run the horizontal manoeuvre of
Table 3 with (only that gives the paper's 50 mm), and what the table's letter says."""
VARIATIONS = tuple(
    # A coefficient of friction that stays: the force goes with the tension.
    Variation(tension=share, friction=share, weight=weight)
    for share, weight in ((1.0, 0.5), (0.99, 0.25), (1.01, 0.25))
)
"""Robots that a design is tried on, the first as fitted."""


class Effort(NamedTuple):
    """How much is spent on a search."""

    population: int = 32
    """Designs of a generation."""
    generations: int = 12
    """Generations."""
    descents: int = 8
    """Steps of gradient descent that follow."""


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


def optimise(
    task: Task,
    within: Admissible,
    *,
    impulses: int = IMPULSES,
    leg_times: tuple[float, ...] = LEG_TIMES,
    effort: Effort = Effort(),  # noqa: B008 - a frozen tuple
    seed: int = 0,
    progress: Progress = SILENT,
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
    weights = np.asarray(around.ensemble.weight)
    baseline = {leg: runs(around, alone(), unshaped(impulses), leg) for leg in leg_times}
    template, unflatten = jax.flatten_util.ravel_pytree(middle(impulses))

    def population_losses(
        designs: Float[np.ndarray, "population n"],
    ) -> Float[np.ndarray, " population"]:
        """Mean loss of each design, the pretension as fitted counting half."""
        crossed = len(designs), len(VARIATIONS)
        lanes = jax.tree.map(
            lambda leaf: np.repeat(np.asarray(leaf), crossed[1], axis=0),
            _laws(jnp.asarray(designs), within, impulses=impulses),
        )
        tasks = jax.tree.map(lambda leaf: np.concatenate([leaf] * crossed[0]), around)
        total = np.zeros(crossed[0])
        for leg, before in baseline.items():
            after = runs(tasks, *lanes, leg)
            each = losses(jax.tree.map(lambda leaf: leaf.reshape(crossed), after), before)
            total += np.asarray(each) @ weights / len(baseline)
        return total

    search = cross_entropy(
        population_losses,
        np.asarray(template),
        spread_of(impulses),
        population=effort.population,
        generations=effort.generations,
        seed=seed,
        progress=progress.part(0.0, 1.0, "gains and shaper: search"),
    )
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
    before = [np.asarray(losses(scores, scores)) @ weights for scores in baseline.values()]
    return Optimum(
        controller_of(within, design),
        shaper_of(design),
        float(least),
        float(np.mean(before)),
    )


def search_preparations(
    task: Task,
    *,
    impulses: int = IMPULSES,
    leg_times: tuple[float, ...] = LEG_TIMES,
) -> Iterator[Callable[[], None]]:
    """What compiles what `optimise` needs for any robot.

    Args:
        task: A robot and the manoeuvre's poses.
        impulses: Impulses of the shaper.
        leg_times: Times of a leg that the same shaper is to serve [s].

    Yields:
        Functions that may be called in any order, and side by side.
    """
    flat, _ = jax.flatten_util.ravel_pytree(middle(impulses))
    nothing = LegMeasures(*[np.zeros(())] * len(dataclasses.fields(LegMeasures)))
    given = flat, task, any_bounds(task.ensemble.robot), (nothing,) * len(leg_times)
    yield functools.partial(_slope.compile, *given, impulses=impulses, leg_times=leg_times)
    for leg in leg_times:
        law = alone(), unshaped(impulses)
        yield functools.partial(compile_runs, _around(task), *law, leg)


def _around(task: Task) -> Task:
    """The task for each of `VARIATIONS`, stacked."""
    single = task.ensemble
    ensemble = jax.tree.map(np.asarray, varied(single.robot, VARIATIONS, single.position))
    return Task(ensemble, np.tile(np.asarray(task.turn), (len(VARIATIONS), 1)))


@kept_jit
def _slope(
    flat: Float[Array, " n"],
    task: Task,
    within: Admissible,
    baseline: tuple[LegMeasures, ...],
    *,
    impulses: int,
    leg_times: tuple[float, ...],
) -> tuple[Float[Array, ""], Float[Array, " n"]]:
    """Mean loss of a design at the pretension as fitted, and its gradient.

    Forward mode: there are a handful of numbers, and nothing of the run is stored.
    """
    _, unflatten = jax.flatten_util.ravel_pytree(middle(impulses))

    def total(flat: Float[Array, " n"]) -> Float[Array, ""]:
        design = unflatten(flat)
        pd, shaper = at_period(COARSE_PERIOD, controller_of(within, design)), shaper_of(design)
        each = []
        for leg, before in zip(leg_times, baseline, strict=True):
            samples = samples_for(leg, COARSE_PERIOD)
            after = track(task, pd, shaper, jnp.asarray(leg), samples=samples).measures
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
    memory = _ADAM.init(point)
    best, least = point, np.inf
    for number in range(steps):
        progress("gains and shaper: descent", number / steps)
        value, gradient = slope(point)
        if float(value) < least:
            best, least = point, float(value)
        point, memory = _adams_step(point, gradient, memory)
    return np.asarray(best)


_ADAM = optax.chain(optax.clip_by_global_norm(1.0), optax.adam(1e-2))


@jax.jit
def _adams_step(
    point: Float[Array, " n"], gradient: Float[Array, " n"], memory: optax.OptState
) -> tuple[Float[Array, " n"], optax.OptState]:
    # Adam's bias correction mixes a float with a counter, which strict promotion refuses.
    with jax.numpy_dtype_promotion("standard"):
        change, memory = _ADAM.update(gradient, memory, point)
    return optax.apply_updates(point, change), memory


@functools.partial(jax.jit, static_argnames="impulses")
def _laws(
    designs: Float[Array, "population n"], within: Admissible, *, impulses: int
) -> tuple[PD, Shaper]:
    """Controllers at the search's period, and shapers, of flat designs."""
    _, unflatten = jax.flatten_util.ravel_pytree(middle(impulses))

    def law(flat: Float[Array, " n"]) -> tuple[PD, Shaper]:
        design = unflatten(flat)
        return at_period(COARSE_PERIOD, controller_of(within, design)), shaper_of(design)

    return jax.vmap(law)(designs)
