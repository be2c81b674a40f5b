"""Least-squares fits of four parameters to exact positions, one and many at once."""

from collections.abc import Iterator

import diffrax
import equinox as eqx
import jax.numpy as jnp
import numpy as np
import optimistix
from jaxtyping import Array, Float

from experiments.benchmarks.line import Line, Settings
from experiments.benchmarks.measurements.batched import batched
from experiments.benchmarks.measurements.timing import interleaved
from experiments.benchmarks.peers.contender import Contender
from experiments.benchmarks.peers.diffrax_peers import SmoothedLinear
from experiments.benchmarks.peers.engines import LinearEngine
from experiments.benchmarks.problem import FREE, MIDDLE, PARTS, REFINED, drawn

BATCHES = (1, 256)
"""Fits at once."""
CHUNK = 64
"""Fits that go on together."""
STEPS = 30
"""Most iterations of a fit."""
FOUND = 1e-2
"""Largest error of any value with which a fit counts as having found the truth [1]."""
CAMERA = 1.9e-4
"""The camera's noise, which residuals are counted in [m]."""


class Fit(eqx.Module):
    """Levenberg-Marquardt from the problem's middle, which is up to 30 % off."""

    contender: Contender
    """What simulates."""

    def __call__(self, measured: Float[Array, "rows 5"]) -> Float[Array, "4"]:
        middle = jnp.asarray(MIDDLE)

        def residuals(logs: Float[Array, "4"], _: None) -> Float[Array, "rows 5"]:
            return (self.contender(middle * jnp.exp(logs)) - measured) / CAMERA

        solution = optimistix.least_squares(
            residuals,
            optimistix.LevenbergMarquardt(rtol=1e-5, atol=1e-6),
            jnp.zeros(len(FREE)),
            options={"jac": "fwd"},
            max_steps=STEPS,
            throw=False,
        )
        return middle * jnp.exp(solution.value)


def linear(settings: Settings) -> Iterator[Line]:
    """Fits of the linear model.

    Args:
        settings: How thoroughly to measure.

    Yields:
        Lines of the table.
    """
    row = "fit of 4, linear"
    forward_mode = SmoothedLinear(diffrax.Tsit5(), 1e-4, diffrax.ForwardMode())
    batches = [b for b in BATCHES if b <= max(settings.largest_batch, 1)]
    truth = drawn(max(batches))
    measured = batched(LinearEngine(REFINED * PARTS), truth, chunk=min(CHUNK, len(truth)))
    for batch in batches:
        taking_part = {"this": Fit(LinearEngine())}
        if batch == 1:
            taking_part["diffrax ForwardMode, Tsit5 1e-4"] = Fit(forward_mode)
        times = interleaved(
            {
                name: lambda fit=fit, batch=batch: batched(
                    fit, measured[:batch], chunk=min(CHUNK, batch)
                )
                for name, fit in taking_part.items()
            },
            repeats=settings.repeats,
        )
        for name, timed in times.items():
            off = np.abs(timed.result / truth[:batch] - 1).max(axis=1)
            right = off < FOUND
            yield Line(
                row=row,
                contender=name,
                batch=batch,
                median=timed.median,
                rate=batch / timed.median,
                unit="fit",
                compile=timed.compile,
                ratio=f"{timed.median / times['this'].median:.2f} times this one's time",
                error=f"{np.median(off):.1e} of a value (median)",
                note=f"{right.sum()} of {batch} within {FOUND:.0%} of every value",
            )
    yield Line(
        row,
        "diffrax ForwardMode, Tsit5 1e-4",
        2,
        note="256 fits not run: see its Jacobians for what they cost",
    )
