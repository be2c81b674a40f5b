"""Which experiment next: the run that sharpens what is known the most per second.

Every excitation of a catalogue is judged by what it is expected to tell; the best of each shape
are improved by gradient. A search ends at what was lucky for the robots that it searched with,
so its ends and what it began at are judged anew, side by side, with others.
"""

import concurrent.futures
import dataclasses
from collections.abc import Callable, Iterator, Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float, PRNGKeyArray

from identification.next_run.excitation import Excitation, moving
from identification.next_run.expected_information import (
    Expected,
    PlannedRun,
    Rig,
    expected,
    expected_over,
)
from scdpr_jax.numerics.progress import SILENT, Progress
from scdpr_jax.numerics.side_by_side import CORES
from scdpr_jax.robot.quantities import value

DRAWS, JUDGES = 4, 32
"""Robots drawn to compare the catalogue with and for each step of the search, and to judge what
the search ends with."""

LANES = 8
"""Excitations that are simulated side by side."""

STARTS = 3
"""Excitations that the search begins at."""

KNOTS = 16
"""Knots of what the search adds to each voltage."""

SOFTNESS = 0.01
"""Excursion beyond a limit that costs as much as a unit of the criterion [m, or m/s]."""

RATE = 0.05
"""Length of the search's steps, in arctanh of the voltage over its limit [1]."""

Criterion = Callable[[Float[Array, "n n"]], Float[Array, ""]]
"""What is minimised, of the expected covariance as a fit holds the quantities."""


def sharpest(index: int) -> Criterion:
    """The criterion that minds a single quantity: its standard error's logarithm.

    Args:
        index: Number of the quantity.

    Returns:
        The criterion.
    """
    return lambda covariance: jnp.log(covariance[index, index]) / 2


def d_optimal(covariance: Float[Array, "n n"]) -> Float[Array, ""]:
    """Mean logarithm of the confidence ellipsoid's axes.

    Args:
        covariance: Covariance.

    Returns:
        The criterion [1].
    """
    return jnp.linalg.slogdet(covariance)[1] / (2 * covariance.shape[0])


def a_optimal(now: Float[np.ndarray, " n"]) -> Criterion:
    """The criterion of the mean variance, each over what it is now.

    Args:
        now: Standard errors now.

    Returns:
        The criterion: half of its logarithm.
    """

    def criterion(covariance: Float[Array, "n n"]) -> Float[Array, ""]:
        return jnp.log(jnp.mean(jnp.diag(covariance) / jnp.square(jnp.asarray(now)))) / 2

    return criterion


@dataclasses.dataclass(frozen=True, eq=False)
class Candidate:
    """An excitation and what it is worth."""

    excitation: Excitation
    """The excitation."""
    sigma: Float[np.ndarray, " n"]
    """Expected standard errors of the quantities with it, as a fit holds them."""
    gain: float
    """Fall of the criterion, a logarithm of standard errors [1]."""

    @property
    def rate(self) -> float:
        """Fall of the criterion per second of rig time [1/s]."""
        return self.gain / self.excitation.duration


def propose(
    rig: Rig,
    excitations: Sequence[Excitation],
    criterion: Criterion,
    *,
    key: PRNGKeyArray,
    iterations: int = 40,
    progress: Progress = SILENT,
) -> tuple[Candidate, ...]:
    """The best excitation of each shape, and what a search by gradient makes of them.

    Reference: K. Chaloner, I. Verdinelli, "Bayesian experimental design: a review",
    Statistical Science 10(3), 1995, doi:10.1214/ss/1177009939.

    Args:
        rig: What is known of the rig.
        excitations: The catalogue.
        criterion: `d_optimal`, `a_optimal(now)` or `sharpest(index)`.
        key: Of the robots that are drawn.
        iterations: Steps of the search; 0 for the catalogue alone.
        progress: Told what is being done and which share of it is done.

    Returns:
        Those that keep within voltage, frame and speed for every robot drawn, the one that
        makes the criterion fall most per second first.

    Raises:
        ValueError: If no excitation of the catalogue keeps within frame and speed.
    """
    comparing, searching, judging = jax.random.split(key, 3)
    intervals = max(excitation.voltage.shape[0] for excitation in excitations)
    design = _Design(rig, criterion, intervals)
    candidates = design.judged(
        excitations, rig.draws(comparing, DRAWS), progress.part(0.0, 0.5, "the catalogue")
    )
    best: dict[str, Candidate] = {}
    for candidate in sorted(candidates, key=_falling_rate):
        best.setdefault(candidate.excitation.shape, candidate)
    if not best:
        raise ValueError(
            f"no excitation keeps clear of the frame and below {float(rig.top_speed):g} m/s, "
            f"got {len(excitations)} to choose from. Allow for a higher speed, or start "
            "elsewhere."
        )
    chosen = [candidate.excitation for candidate in best.values()]
    starts = [excitation for excitation in chosen if excitation.knock == 0][:STARTS]
    if starts and iterations:
        inner = progress.part(0.5, 0.9, "improved by gradient")
        chosen += design.improved(starts, searching, iterations=iterations, progress=inner)
    progress("judged anew", 0.9)
    final = design.judged(chosen, rig.draws(judging, JUDGES))
    return tuple(sorted(final, key=_falling_rate))


def _falling_rate(candidate: Candidate) -> float:
    return -candidate.rate


@dataclasses.dataclass(frozen=True, eq=False)
class _Design:
    """What excitations are judged by."""

    rig: Rig
    criterion: Criterion
    intervals: int
    """What runs are padded to."""

    def judged(
        self,
        excitations: Sequence[Excitation],
        truths: Float[Array, "draws n"],
        progress: Progress = SILENT,
    ) -> list[Candidate]:
        """A candidate for each excitation that keeps within the limits for every truth."""
        rig = self.rig
        before = float(self.criterion(rig.root @ rig.root.T))
        expectations = self.expectations(excitations, truths, progress)
        candidates = []
        for row, excitation in enumerate(excitations):
            if not expectations.beyond[row] > 0.0:
                covariance = rig.covariance(jnp.asarray(expectations.units[row]))
                sigma = np.sqrt(np.diag(np.asarray(covariance)))
                gain = before - float(self.criterion(covariance))
                candidates.append(Candidate(excitation, sigma, gain))
        return candidates

    def expectations(
        self,
        excitations: Sequence[Excitation],
        truths: Float[Array, "draws n"],
        progress: Progress = SILENT,
    ) -> Expected:
        """What excitations tell on average over the truths, and how far they exceed limits."""
        chunks = [
            (excitations[first : first + LANES], truths[drawn : drawn + DRAWS])
            for first in range(0, len(excitations), LANES)
            for drawn in range(0, len(truths), DRAWS)
        ]

        def tell(chunk: tuple[Sequence[Excitation], Float[Array, "draws n"]]) -> Expected:
            # Chunks of one size: one compilation.
            filled = [*chunk[0], *chunk[0][:1] * (LANES - len(chunk[0]))]
            expectation = _over_all(self.rig, stacked(filled, self.intervals), chunk[1])
            return jax.tree.map(lambda leaf: np.asarray(leaf)[: len(chunk[0])], expectation)

        def in_order() -> Iterator[Expected]:
            # Threads that find nothing compiled would all compile it.
            yield tell(chunks[0])
            with concurrent.futures.ThreadPoolExecutor(CORES) as threads:
                yield from threads.map(tell, chunks[1:])

        parts: list[Expected] = []
        for part in in_order():
            parts.append(part)
            progress("", len(parts) / len(chunks))
        every = len(truths) // DRAWS
        rows = [parts[first : first + every] for first in range(0, len(parts), every)]
        return Expected(
            np.concatenate([np.mean([part.units for part in row], axis=0) for row in rows]),
            np.concatenate([np.max([part.beyond for part in row], axis=0) for row in rows]),
        )

    def improved(
        self,
        starts: Sequence[Excitation],
        key: PRNGKeyArray,
        *,
        iterations: int,
        progress: Progress = SILENT,
    ) -> list[Excitation]:
        """The best of each start on the way of Adam's steps, by other robots at every step."""
        rig, runs = self.rig, stacked(starts, self.intervals)
        # The secants go over what the starts leave uncertain.
        uncertain = self.expectations(starts, rig.draws(key, DRAWS)).units
        over = jnp.asarray(np.linalg.cholesky(uncertain))
        limit = float(value(rig.robot, "voltage_limit"))
        base = jnp.arctanh(0.98 * jnp.clip(runs.voltage / limit, -1.0, 1.0))
        spread = jnp.stack([jnp.asarray(_hats(int(n), base.shape[1])) for n in runs.length])
        lanes = (runs, base, spread, over)
        knots = jnp.zeros((len(starts), KNOTS, 2))
        optimiser = optax.adam(RATE)
        state = optimiser.init(knots)
        least, best = np.full(len(starts), np.inf), list(starts)
        for number in range(iterations):
            progress("", number / iterations)
            truths = rig.draws(jax.random.fold_in(key, number), DRAWS)
            slope, cost, voltage = _sloped(rig, self.criterion, knots, lanes, truths)
            for lane, start in enumerate(starts):
                if float(cost[lane]) < least[lane]:
                    least[lane] = float(cost[lane])
                    length = start.voltage.shape[0]
                    best[lane] = start.replaced(np.asarray(voltage[lane, :length]))
            slope = jnp.where(jnp.isfinite(slope), slope, 0.0)
            # optax raises a float to the power of an integer count.
            with jax.numpy_dtype_promotion("standard"):
                change, state = optimiser.update(slope, state)
            knots = optax.apply_updates(knots, change)
        return best


@eqx.filter_jit
def _over_all(rig: Rig, runs: PlannedRun, truths: Float[Array, "draws n"]) -> Expected:
    def mean(run: PlannedRun) -> Expected:
        each = jax.vmap(expected, in_axes=(None, None, 0))(rig, run, truths)
        return Expected(jnp.mean(each.units, axis=0), jnp.max(each.beyond))

    return jax.vmap(mean)(runs)


def stacked(excitations: Sequence[Excitation], intervals: int) -> PlannedRun:
    """Excitations as arrays of one size.

    Args:
        excitations: The excitations.
        intervals: Intervals to pad to.

    Returns:
        Their runs along a leading axis.
    """
    each = [
        PlannedRun(
            voltage=np.pad(e.voltage, [(0, intervals - e.voltage.shape[0]), (0, 0)]),
            start=np.array(e.start),
            knock=e.knock,
            length=float(e.voltage.shape[0]),
        )
        for e in excitations
    ]
    return jax.tree.map(lambda *leaves: jnp.stack(leaves), *each)


@eqx.filter_jit
def _sloped(
    rig: Rig,
    criterion: Criterion,
    knots: Float[Array, "lanes knots 2"],
    lanes: tuple[PlannedRun, Array, Array, Array],
    truths: Float[Array, "draws n"],
) -> tuple[
    Float[Array, "lanes knots 2"], Float[Array, " lanes"], Float[Array, "lanes intervals 2"]
]:
    """Slope of the penalised criterion over the knots, it itself, and the voltages."""
    limit = rig.robot.drive.voltage_limit

    def cost(knots: Array, run: PlannedRun, base: Array, spread: Array, over: Array) -> tuple:
        moves = jnp.any(spread > 0, axis=1)[:, None]
        voltage = limit * jnp.where(moves, jnp.tanh(base + spread @ knots), 0.0)
        planned = eqx.tree_at(lambda r: r.voltage, run, voltage)
        each = jax.vmap(expected_over, in_axes=(None, None, 0, None))(
            rig, planned, truths, over
        )
        mean = rig.covariance(jnp.mean(each.units, axis=0))
        total = criterion(mean) + jnp.max(each.beyond) / SOFTNESS
        return total, (total, voltage)

    def sloped(lane: tuple) -> tuple:
        slope, (total, voltage) = jax.grad(cost, has_aux=True)(*lane)
        return slope, total, voltage

    # One after the other: what reverse mode keeps of a lane fills the memory as it is.
    return jax.lax.map(sloped, (knots, *lanes))


def _hats(length: int, intervals: int) -> Float[np.ndarray, "intervals knots"]:
    """Linear interpolation between knots over the time in which a run may move."""
    at = np.flatnonzero(moving(length))
    place = np.linspace(0, KNOTS - 1, at.size)
    spread = np.zeros((intervals, KNOTS))
    spread[at] = np.maximum(1 - np.abs(place[:, None] - np.arange(KNOTS)[None]), 0.0)
    return spread
