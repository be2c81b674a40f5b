"""Jacobians by four parameters, in one forward-mode pass."""

from collections.abc import Iterator

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from experiments.benchmarks.batched import batched
from experiments.benchmarks.contender import Contender
from experiments.benchmarks.diffrax_peers import SmoothedLinear
from experiments.benchmarks.engines import LinearEngine
from experiments.benchmarks.line import Line, Settings
from experiments.benchmarks.problem import ARM, FREE, PARTS, REFINED, drawn
from experiments.benchmarks.timing import interleaved

BATCHES = (64, 1024)
"""Runs at once."""
CHUNK = 64
"""Of every contender."""
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


def linear(settings: Settings) -> Iterator[Line]:
    """Jacobians of the linear model.

    Args:
        settings: How thoroughly to measure.

    Yields:
        Lines of the table.
    """
    row = "Jacobian by 4, linear"
    engine = LinearEngine()
    forward_mode = SmoothedLinear(diffrax.Tsit5(), 1e-4, diffrax.ForwardMode())
    values = drawn(max(JUDGED, settings.largest_batch))
    exact = Jacobian(LinearEngine(REFINED * PARTS))
    truth = batched(exact, values[:JUDGED], chunk=JUDGED)
    for batch in (b for b in BATCHES if b <= settings.largest_batch):
        taking_part = {"forward": engine, "this": Jacobian(engine)}
        if batch <= PEER_UP_TO:
            taking_part["diffrax ForwardMode, Tsit5 1e-4"] = Jacobian(forward_mode)
        times = interleaved(
            {
                name: lambda contender=contender, batch=batch: batched(
                    contender, values[:batch], chunk=min(CHUNK, batch)
                )
                for name, contender in taking_part.items()
            },
            repeats=settings.repeats,
        )
        ours = times["this"].median
        for name in list(taking_part)[1:]:
            timed = times[name]
            forward = timed.median / times["forward"].median
            ratio = f"{forward:.1f} times this engine's forward"
            if name != "this":
                ratio += f"; this is {timed.median / ours:.1f} × faster"
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
                note=f"chunks of {min(CHUNK, batch)}",
            )
    yield Line(
        row,
        "diffrax ForwardMode, Tsit5 1e-4",
        PEER_UP_TO + 1,
        note="larger batches not run, to keep this short",
    )


def _error(
    found: Float[np.ndarray, "runs rows 5 4"], truth: Float[np.ndarray, "runs rows 5 4"]
) -> str:
    """Median and worst over the runs, as a share of each run's largest derivative."""
    scale = np.array([1.0, ARM, 1.0, 1.0, 1.0])[:, None]
    off = np.abs((found - truth[: len(found)]) * scale).max(axis=(1, 2, 3))
    share = off / np.abs(truth[: len(found)] * scale).max(axis=(1, 2, 3))
    return f"{np.median(share):.1e}, worst {share.max():.1e} of the largest"
