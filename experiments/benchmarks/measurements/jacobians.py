"""Jacobians by four parameters, in one forward-mode pass."""

from collections.abc import Callable, Iterator

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from experiments.benchmarks.line import Line, Settings
from experiments.benchmarks.measurements.batched import batched, best_chunk, call
from experiments.benchmarks.measurements.timing import interleaved
from experiments.benchmarks.peers.contender import Contender
from experiments.benchmarks.peers.diffrax_peers import Smoothed, SmoothedLinear
from experiments.benchmarks.peers.engines import LinearEngine, NonlinearEngine
from experiments.benchmarks.problem import ARM, FREE, PARTS, REFINED, drawn

BATCHES = (64, 1024)
"""Runs at once."""
CHUNKS = (8, 16, 32, 64, 128)
"""Chunks among which each of ours has its fastest."""
PEER_UP_TO = 64
"""Largest batch of diffrax's forward mode."""
JUDGED = 16
"""Runs whose Jacobians are looked at."""


class Jacobian(Contender):
    """Derivatives of a contender's positions by the logarithms of its values."""

    contender: Contender
    """Whose."""

    def __call__(self, values: Float[Array, "4"]) -> Float[Array, "rows 5 4"]:
        logs = jnp.zeros(len(FREE), values.dtype)
        return jax.jacfwd(lambda at: self.contender(values * jnp.exp(at)))(logs)


class Wide(Contender):
    """Derivatives by twenty numbers, of which each moves all values."""

    contender: Contender
    """Whose."""

    def __call__(self, values: Float[Array, "4"]) -> Float[Array, "rows 5 20"]:
        turn = jnp.cos(jnp.outer(jnp.arange(20.0), jnp.arange(1.0, 1 + len(FREE))))
        logs = jnp.zeros(20, values.dtype)
        return jax.jacfwd(lambda at: self.contender(values * jnp.exp(at @ turn)))(logs)


def linear(settings: Settings) -> Iterator[Line]:
    """Jacobians of the linear model.

    Args:
        settings: How thoroughly to measure.

    Yields:
        Lines of the table.
    """
    yield from _jacobians("Jacobian by 4, linear", LinearEngine, SmoothedLinear, settings)


def nonlinear(settings: Settings) -> Iterator[Line]:
    """Jacobians of the nonlinear model.

    Args:
        settings: How thoroughly to measure.

    Yields:
        Lines of the table.
    """
    yield from _jacobians("Jacobian by 4, nonlinear", NonlinearEngine, Smoothed, settings)


def _jacobians(
    row: str,
    engine: Callable[[int], Contender],
    smooth: Callable[[diffrax.AbstractSolver, float, diffrax.AbstractAdjoint], Contender],
    settings: Settings,
) -> Iterator[Line]:
    peer = "diffrax ForwardMode, Tsit5 1e-4"
    forward_mode = Jacobian(smooth(diffrax.Tsit5(), 1e-4, diffrax.ForwardMode()))
    ours = {"forward": engine(PARTS), "this": Jacobian(engine(PARTS))}
    values = drawn(max(JUDGED, settings.largest_batch))
    exact = Jacobian(engine(REFINED * PARTS))
    truth = batched(exact, values[:JUDGED], chunk=JUDGED)
    # The peer's is the slowest of all: its chunk is the batch.
    chunk = {
        name: best_chunk(one, values, CHUNKS, largest=settings.largest_batch)
        for name, one in ours.items()
    }
    for batch in (b for b in BATCHES if b <= settings.largest_batch):
        taking_part = {**ours, peer: forward_mode} if batch <= PEER_UP_TO else ours
        size = {name: min(chunk.get(name, batch), batch) for name in taking_part}
        times = interleaved(
            {
                name: call(contender, values[:batch], size[name])
                for name, contender in taking_part.items()
            },
            repeats=settings.repeats,
        )
        for name in list(taking_part)[1:]:
            timed = times[name]
            forward = timed.median / times["forward"].median
            ratio = f"{forward:.1f} times this engine's forward"
            if name != "this":
                ratio += f"; this is {timed.median / times['this'].median:.1f} × faster"
            yield Line(
                row=row,
                contender=name,
                batch=batch,
                median=timed.median,
                rate=batch / timed.median,
                unit="Jacobian",
                compile=timed.compile,
                ratio=ratio,
                error=_error(timed.result[:JUDGED], truth),
                note=f"chunks of {size[name]}, forward of {size['forward']}",
            )
    yield Line(row, peer, PEER_UP_TO + 1, note="larger batches not run, to keep this short")
    yield _wide(row.replace("by 4", "by 20"), engine(PARTS), values, settings)


def _wide(
    row: str, forward: Contender, values: Float[np.ndarray, "runs 4"], settings: Settings
) -> Line:
    """Jacobians by twenty numbers beside forward runs."""
    batch = min(BATCHES[0], settings.largest_batch)
    calls = {"forward": forward, "this": Wide(forward)}
    times = interleaved(
        {name: call(contender, values[:batch], batch) for name, contender in calls.items()},
        repeats=settings.repeats,
    )
    timed = times["this"]
    return Line(
        row=row,
        contender="this",
        batch=batch,
        median=timed.median,
        rate=batch / timed.median,
        unit="Jacobian",
        compile=timed.compile,
        ratio=f"{timed.median / times['forward'].median:.1f} times this engine's forward",
        note=f"chunks of {batch}",
    )


def _error(
    derivatives: Float[np.ndarray, "runs rows 5 4"], truth: Float[np.ndarray, "runs rows 5 4"]
) -> str:
    """Median and worst over the runs, as a share of each run's largest derivative."""
    scale = np.array([1.0, ARM, 1.0, 1.0, 1.0])[:, None]
    off = np.abs((derivatives - truth[: len(derivatives)]) * scale).max(axis=(1, 2, 3))
    share = off / np.abs(truth[: len(derivatives)] * scale).max(axis=(1, 2, 3))
    return f"{np.median(share):.1e}, worst {share.max():.1e} of the largest"
