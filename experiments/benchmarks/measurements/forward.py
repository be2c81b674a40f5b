"""Forward runs: both engines beside their peers, at batches from one to thousands."""

from collections.abc import Callable, Iterator

import diffrax
import numpy as np
from jaxtyping import Float

from experiments.benchmarks.line import Line, Settings
from experiments.benchmarks.measurements.batched import batched, best_chunk, call
from experiments.benchmarks.measurements.timing import Timed, interleaved
from experiments.benchmarks.peers import casadi_peer, mujoco_peer, scipy_peer
from experiments.benchmarks.peers.contender import Contender
from experiments.benchmarks.peers.diffrax_peers import Smoothed, SmoothedLinear
from experiments.benchmarks.peers.engines import ByXla, LinearEngine, NonlinearEngine
from experiments.benchmarks.peers.smoothed_robot import WIDTH
from experiments.benchmarks.problem import DURATION, LOG, PARTS, REFINED, drawn, error

BATCHES = (1, 64, 1024, 4096)
"""Runs at once."""
JUDGED = 16
"""Runs whose errors are looked at."""
CHUNKS = (16, 64, 128, 256)
"""Chunks among which each contender has its fastest."""
COARSE = {LinearEngine: 2, NonlinearEngine: 4}
"""Fewest steps in an interval of the log that keep the error under 1e-5 m, by engine."""
BESIDE = {
    LinearEngine: {"this, drives followed": LinearEngine(PARTS, rubbing_drives=True)},
    NonlinearEngine: {"this, by XLA": ByXla(PARTS)},
}
"""By engine: the linear one following the drives' dry friction, which it can leave out, and
what the nonlinear one's step is without machine code."""
IMPLICIT_UP_TO = 64
"""Largest batch of the implicit solver, the slowest."""


def linear(settings: Settings) -> Iterator[Line]:
    """The linear model.

    Args:
        settings: How thoroughly to measure.

    Yields:
        Lines of the table.
    """
    yield from _forward("forward, linear", LinearEngine, SmoothedLinear, settings)


def nonlinear(settings: Settings) -> Iterator[Line]:
    """The nonlinear model.

    Args:
        settings: How thoroughly to measure.

    Yields:
        Lines of the table.
    """
    row = "forward, nonlinear"
    yield from _forward(row, NonlinearEngine, Smoothed, settings)
    truth = batched(NonlinearEngine(REFINED * PARTS), drawn(JUDGED), chunk=JUDGED)[0]
    yield _single(row, scipy_peer.NAME, scipy_peer.run, truth, settings)
    for peer in (casadi_peer, mujoco_peer):
        if missing := peer.missing():
            yield Line(row, peer.NAME, 1, note=f"not run: {missing}")
        else:
            yield _single(row, peer.NAME, peer.run, truth, settings)


def _forward(
    row: str,
    engine: type[LinearEngine | NonlinearEngine],
    smooth: Callable[[diffrax.AbstractSolver, float], Contender],
    settings: Settings,
) -> Iterator[Line]:
    values = drawn(max(JUDGED, settings.largest_batch))
    truth = batched(engine(REFINED * PARTS), values[:JUDGED], chunk=JUDGED)
    smoothed = batched(smooth(diffrax.Tsit5(), 1e-9), values[:JUDGED], chunk=JUDGED)
    single = values.astype(np.float32)
    contenders = {
        "this": (engine(PARTS), values),
        f"this, {COARSE[engine] / LOG:g} Hz": (engine(COARSE[engine]), values),
        **{name: (own, values) for name, own in BESIDE[engine].items()},
        "this, float32": (engine(PARTS), single),
        "diffrax Tsit5 1e-4": (smooth(diffrax.Tsit5(), 1e-4), values),
        "diffrax Kvaerno5 1e-5": (smooth(diffrax.Kvaerno5(), 1e-5), values),
    }
    chunk = {
        name: best_chunk(*contender, CHUNKS, largest=settings.largest_batch)
        for name, contender in contenders.items()
        if "Kvaerno5" not in name
    }
    for batch in (b for b in BATCHES if b <= settings.largest_batch):
        taking_part = {
            name: contender
            for name, contender in contenders.items()
            if "Kvaerno5" not in name or batch <= IMPLICIT_UP_TO
        }
        size = {name: min(chunk.get(name, IMPLICIT_UP_TO), batch) for name in taking_part}
        times = interleaved(
            {
                name: call(contender, points[:batch], size[name])
                for name, (contender, points) in taking_part.items()
            },
            repeats=settings.repeats,
        )
        for name in taking_part:
            own = smoothed if "diffrax" in name else None
            yield _line(row, name, batch, size[name], times, truth, own)
    yield Line(
        row,
        "diffrax Kvaerno5 1e-5",
        IMPLICIT_UP_TO + 1,
        note="larger batches not run, to keep this short",
    )


def _line(
    row: str,
    name: str,
    batch: int,
    chunk: int,
    times: dict[str, Timed],
    truth: Float[np.ndarray, "runs rows 5"],
    own: Float[np.ndarray, "runs rows 5"] | None,
) -> Line:
    timed, peer = times[name], times["diffrax Tsit5 1e-4"]
    positions = timed.result[:JUDGED]
    notes = [f"chunks of {chunk}"]
    if own is not None:
        from_own = error(positions, own[: len(positions)])
        notes.append(f"width {WIDTH:g} m/s, {from_own:.1e} m off its own exact solution")
    return Line(
        row=row,
        contender=name,
        batch=batch,
        median=timed.median,
        rate=batch * DURATION / timed.median,
        unit="robot-s",
        compile=timed.compile,
        ratio=f"{peer.median / timed.median:.2f} × Tsit5",
        error=f"{error(positions, truth[: len(positions)]):.1e} m",
        note=", ".join(notes),
    )


def _single(
    row: str,
    name: str,
    run: Callable[[Float[np.ndarray, "4"]], Float[np.ndarray, "rows 5"]],
    truth: Float[np.ndarray, "rows 5"],
    settings: Settings,
) -> Line:
    values = drawn(1)
    peer = Smoothed(diffrax.Tsit5(), 1e-4)
    calls = {name: lambda: run(values[0]), "Tsit5": call(peer, values, 1)}
    times = interleaved(calls, repeats=settings.repeats)
    timed = times[name]
    return Line(
        row=row,
        contender=name,
        batch=1,
        median=timed.median,
        rate=DURATION / timed.median,
        unit="robot-s",
        compile=timed.compile,
        ratio=f"{times['Tsit5'].median / timed.median:.2f} × Tsit5",
        error=f"{error(timed.result, truth):.1e} m",
    )
