"""From a fresh process to a single run's first result, with compiled functions kept.

Run as a script it is that process.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator

from experiments.benchmarks.line import Line, Settings
from experiments.benchmarks.measurements.timing import interleaved


def single_run(settings: Settings) -> Iterator[Line]:
    """Cold starts of both engines.

    Args:
        settings: How thoroughly to measure.

    Yields:
        Lines of the table.
    """
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "XDG_CACHE_HOME": cache}
        times = interleaved(
            {
                name: lambda name=name: _process(name, environment)
                for name in ("linear", "nonlinear")
            },
            repeats=settings.repeats,
        )
    for name, timed in times.items():
        yield Line(
            row="cold start to first result",
            contender=f"this, {name}",
            batch=1,
            median=timed.median,
            compile=timed.compile,
            note="a fresh process, imports included; compile: what an empty cache adds",
        )


def _process(name: str, environment: dict[str, str]) -> float:
    command = [sys.executable, "-m", "experiments.benchmarks.measurements.cold_start", name]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


def main(name: str) -> None:
    """Simulate one run and print where it ends.

    Args:
        name: "linear" or "nonlinear".
    """
    from experiments.runtime import set_up

    set_up()
    import jax

    from experiments.benchmarks.peers.engines import LinearEngine, NonlinearEngine
    from experiments.benchmarks.problem import drawn

    engine = {"linear": LinearEngine, "nonlinear": NonlinearEngine}[name]()
    print(float(jax.jit(lambda values: engine(values))(drawn(1)[0])[-1, 0]))


if __name__ == "__main__":
    main(sys.argv[1])
