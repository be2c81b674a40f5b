"""The benchmark's table as Markdown and JSON, with the machine and the versions."""

import importlib.metadata
import json
import os
import pathlib
import platform
from collections.abc import Sequence

from experiments.benchmarks.line import Line, Settings
from scdpr_jax.numerics.files import write_whole

PACKAGES = ("scdpr-jax", "jax", "jaxlib", "diffrax", "equinox", "optimistix", "numpy", "scipy")
"""Packages whose versions matter."""
HEADER = ("task", "who", "at once", "time", "rate", "compile", "ratio", "error", "note")
"""Columns of the table."""

_TEXT = """# Performance

Written by `scdpr benchmark`. Every contender solves the same problem: 2 s of the prototype at
T = 350 N and μ = 0.005, each value of μ, J, b and T drawn within ±30 %, 6 V on both drives for
a second and a second of coasting, logged every 25 ms; the engines step at 200 Hz. Times are
medians of calls that take turns; compilation is apart, setting a run up is included. Ratios are
within one run. Everything runs on one device; batches go through `jax.lax.map`, forward runs in
the chunk of 16 to 256 in which each contender is fastest. The drives have no dry friction; the
nonlinear engine looks for it all the same, the linear one where it says so.

Errors are the largest position error in up to 16 runs against exact friction (this engine at
4 kHz, which tests compare with the event-by-event reference); a tilt counts as the displacement
of the attachments. Smoothed friction is another model: most of its error comes from the
smoothing, and its note says how far the solver is from that model's own solution.

{machine}

{table}
"""


def machine() -> dict[str, str]:
    """What the times depend on.

    Returns:
        Processor, cores, load, system and versions.
    """
    versions = {name: importlib.metadata.version(name) for name in PACKAGES}
    return {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "load": f"{os.getloadavg()[0]:.2f}",
        "system": platform.platform(terse=True),
        "Python": platform.python_version(),
        **versions,
    }


def cells(line: Line) -> tuple[str, ...]:
    """A line as the table's texts.

    Args:
        line: The line.

    Returns:
        Texts in the order of `HEADER`.
    """
    return (
        line.row,
        line.contender,
        f"{line.batch:,}" if line.median is not None else f"from {line.batch:,}",
        _seconds(line.median),
        "" if line.rate is None else f"{line.rate:,.3g} {line.unit}/s",
        _seconds(line.compile),
        line.ratio,
        line.error,
        line.note,
    )


def write(
    folder: pathlib.Path, lines: Sequence[Line], on: dict[str, str], settings: Settings
) -> tuple[pathlib.Path, pathlib.Path]:
    """Write `performance.md` and `performance.json`.

    Args:
        folder: Their folder.
        lines: What was measured.
        on: What `machine` said.
        settings: How it was measured.

    Returns:
        Both files.
    """
    about = ", ".join(f"{name} {value}" for name, value in on.items())
    table = [HEADER, ("---",) * len(HEADER), *map(cells, lines)]
    text = "\n".join(f"| {' | '.join(row)} |" for row in table)
    readable, exact = folder / "performance.md", folder / "performance.json"
    write_whole(readable, _TEXT.format(machine=f"Measured on: {about}.", table=text))
    document = {
        "format": 1,
        "machine": on,
        "settings": settings._asdict(),
        "lines": [line._asdict() for line in lines],
    }
    write_whole(exact, json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    return readable, exact


def _seconds(time: float | None) -> str:
    if time is None:
        return ""
    return f"{1e3 * time:.3g} ms" if time < 1 else f"{time:.3g} s"


def _processor() -> str:
    about = pathlib.Path("/proc/cpuinfo")
    if about.exists():
        for line in about.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
