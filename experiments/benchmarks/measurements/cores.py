"""All cores against one, each in a process of its own.

XLA makes its threads for the cores that it finds when it starts, so that a process has to be
told before. Run as a script it is that process.
"""

import os
import subprocess
import sys
import time
from collections.abc import Iterator

from experiments.benchmarks.line import Line, Settings

BATCHES = (256, 1024)
"""Runs at once."""
CALLS = 20
"""Calls of which the fastest counts, as other work only makes one slower."""


def all_over_one(settings: Settings) -> Iterator[Line]:
    """Forward runs of the nonlinear engine on all cores and on one.

    Args:
        settings: How thoroughly to measure.

    Yields:
        Lines of the table.
    """
    every = sorted(os.sched_getaffinity(0)) if sys.platform == "linux" else []
    row = "cores, nonlinear"
    if len(every) < 2:
        yield Line(row, "this", BATCHES[0], note="not run: one core, or it can't be chosen")
        return
    for batch in (b for b in BATCHES if b <= settings.largest_batch):
        one, all_ = (
            min(_process(batch, cores) for _ in range(settings.repeats))
            for cores in (every[:1], every)
        )
        yield Line(
            row=row,
            contender=f"this, {len(every)} cores",
            batch=batch,
            median=all_,
            ratio=f"{one / all_:.2f} times as fast as on one",
            note=f"fastest of {settings.repeats} processes and {CALLS} calls in each",
        )


def _process(batch: int, cores: list[int]) -> float:
    told = ",".join(map(str, cores))
    own = [sys.executable, "-m", __name__, str(batch), told]
    return float(subprocess.run(own, capture_output=True, text=True, check=True).stdout)


def main(batch: int, cores: set[int]) -> None:
    """Simulate a batch again and again on some cores, and print the least time.

    Args:
        batch: Runs at once.
        cores: Numbers of the cores.
    """
    os.sched_setaffinity(0, cores)
    from experiments.runtime import set_up

    set_up()
    import jax
    import jax.numpy as jnp

    from experiments.benchmarks.peers.engines import NonlinearEngine
    from experiments.benchmarks.problem import drawn

    run, values = jax.jit(jax.vmap(NonlinearEngine())), jnp.asarray(drawn(batch))
    times = []
    for _ in range(1 + CALLS):
        begun = time.perf_counter()
        run(values).block_until_ready()
        times.append(time.perf_counter() - begun)
    print(min(times[1:]))


if __name__ == "__main__":
    main(int(sys.argv[1]), {int(core) for core in sys.argv[2].split(",")})
