"""The report of one motor-driven axis: one HTML file that needs nothing else."""

import pathlib

import numpy as np

from experiments.figures.identification.axis import axis_figure
from experiments.page.page import Pictures, page, versions
from experiments.reports.calibration.heat_tables import correlation_heat
from experiments.reports.drive.words import (
    MEANING,
    axis_rows,
    axis_sentences,
    axis_verdict,
    law_sentences,
)
from identification.axis.law import AxisLaws
from identification.axis.log import AxisLog
from scdpr_jax.numerics.files import write_whole


def write_drive_report(path: pathlib.Path, *, log: AxisLog, laws: AxisLaws) -> None:
    """Write the report of an axis, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        log: The axis's log.
        laws: The usual friction law, and the extended one beside it.

    Raises:
        OSError: If the place can't be written to.
    """
    picture, estimate = Pictures(), laws.usual
    text = page(
        "drive.html.j2",
        title="Identification of a motor-driven axis",
        verdict=axis_verdict(laws),
        notes=estimate.notes,
        sentences=[*axis_sentences(estimate), *law_sentences(laws)],
        rows=axis_rows(estimate),
        pictures=[
            picture(
                axis_figure(log, estimate),
                "The simulation runs open loop over the whole record, or from gap to gap: its "
                "distance from the log is the law's own. Where the residual "
                "grows, friction differs from what it is elsewhere.",
            ),
        ],
        correlation=correlation_heat(
            ["".join(MEANING[name][:2]) for name in estimate.names],
            np.asarray(estimate.correlation),
        ),
        provenance=[("samples", f"{log.time.size}"), *versions()],
    )
    write_whole(pathlib.Path(path), text)
