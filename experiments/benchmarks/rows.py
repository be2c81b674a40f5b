"""Every row of the benchmark."""

from collections.abc import Callable, Iterator

from experiments.benchmarks.line import Line, Settings
from experiments.benchmarks.measurements import (
    cold_start,
    cores,
    fits,
    forward,
    frequencies,
    jacobians,
)

ROWS: tuple[tuple[str, Callable[[Settings], Iterator[Line]]], ...] = (
    ("forward-linear", forward.linear),
    ("forward-nonlinear", forward.nonlinear),
    ("jacobian-linear", jacobians.linear),
    ("jacobian-nonlinear", jacobians.nonlinear),
    ("cores", cores.all_over_one),
    ("fit", fits.linear),
    ("frequencies", frequencies.million),
    ("cold-start", cold_start.single_run),
)
"""Names of the rows and what measures them."""
