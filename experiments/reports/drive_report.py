"""The report of one motor-driven axis: one HTML file that needs nothing else."""

import pathlib

import numpy as np

from experiments.figures.identification.axis import axis_figure
from experiments.figures.identification.correlation import correlation
from experiments.page.number_text import percent, plain, readable_unit, rounded
from experiments.page.page import Pictures, page, versions
from experiments.reports.parameter_table import Row
from identification.axis.drive_axis import DriveAxisEstimate
from identification.axis.law import AxisLaws
from identification.axis.log import AxisLog
from scdpr_jax.numerics.files import write_whole

_LINEAR = {
    "mass": "kg",
    "viscous": "N s/m",
    "coulomb": "N",
    "offset": "N",
    "viscous_difference": "N s/m",
}
_ROTARY = {
    "mass": "kg m^2",
    "viscous": "N m s",
    "coulomb": "N m",
    "offset": "N m",
    "viscous_difference": "N m s",
}
_MEANING = {
    "mass": ("M", "", "moving mass, the motor's inertia with it"),
    "viscous": ("F", "v", "viscous friction"),
    "coulomb": ("F", "c", "Coulomb friction"),
    "offset": ("o", "", "constant force against the drive"),
    "viscous_difference": ("ΔF", "v", "viscous friction forwards minus backwards"),
}


def write_drive_report(
    path: pathlib.Path, *, log: AxisLog, estimate: DriveAxisEstimate, laws: AxisLaws
) -> None:
    """Write the report of an axis, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        log: The axis's log.
        estimate: What was found in it.
        laws: The extended friction law beside the usual one.

    Raises:
        OSError: If the place can't be written to.
    """
    picture = Pictures()
    text = page(
        "drive.html.j2",
        title="Identification of a motor-driven axis",
        sentences=[
            *axis_sentences(estimate, position_unit=log.position_unit),
            *law_sentences(laws, position_unit=log.position_unit),
        ],
        rows=axis_rows(estimate, position_unit=log.position_unit),
        pictures=[
            picture(
                axis_figure(log, estimate),
                "The simulation is started once at rest and runs open loop over the whole "
                "record: its distance from the log is the model's own. Where the residual "
                "grows, friction differs from what it is elsewhere.",
            ),
            picture(
                correlation(list(estimate.names), np.asarray(estimate.correlation)),
                "Correlation of the estimates.",
                narrow=True,
            ),
        ],
        provenance=[("samples", f"{log.time.size}"), *versions()],
    )
    write_whole(pathlib.Path(path), text)


def axis_rows(estimate: DriveAxisEstimate, *, position_unit: str) -> list[Row]:
    """The lines of an axis's table of parameters.

    Args:
        estimate: The estimate.
        position_unit: SI unit of its log's positions, "m" or "rad".

    Returns:
        One for each parameter.
    """
    units = _LINEAR if position_unit == "m" else _ROTARY
    rows = []
    for index, name in enumerate(estimate.names):
        number = float(getattr(estimate.parameters, name))
        half = 1.96 * float(getattr(estimate.sigma, name))
        low, high = (float(end) for end in estimate.interval95[index])
        base, lower_index, meaning = _MEANING[name]
        rows.append(
            Row(
                name=name,
                symbol=(base, lower_index),
                meaning=meaning,
                setting="",
                value=rounded(number, half),
                low=rounded(low, half),
                high=rounded(high, half),
                relative=percent(half / abs(number)) if number else "",
                unit=readable_unit(units[name]),
                status=estimate.status[index].replace("_", " "),
                truth="",
                error="",
                covered="",
            )
        )
    return rows


def axis_sentences(estimate: DriveAxisEstimate, *, position_unit: str) -> list[str]:
    """What an axis's estimate comes to, in plain words.

    Args:
        estimate: The estimate.
        position_unit: SI unit of its log's positions, "m" or "rad".

    Returns:
        Sentences: one for each parameter, then how far to trust them.
    """
    unit = "mm" if position_unit == "m" else "mrad"
    error, motion = (
        float(estimate.open_loop_rmse),
        float(np.ptp(np.asarray(estimate.positions))),
    )
    sentences = [
        f"{row.meaning.capitalize()}: {row.value} {row.unit}, 95 % from {row.low} to "
        f"{row.high} ({row.status})."
        for row in axis_rows(estimate, position_unit=position_unit)
    ]
    sentences.append(
        f"Open loop over the whole record the axis is predicted to {plain(1e3 * error, 3)} "
        f"{unit} rms, {percent(error / motion)} of its {plain(1e3 * motion, 3)} {unit} of "
        "motion."
    )
    sentences.append(
        f"{estimate.agreeing_starts} of {estimate.starts} starts of the search agree; the "
        f"residuals hang together for {plain(float(estimate.memory))} s, which the intervals "
        "take into account."
    )
    if not estimate.converged:
        sentences.append("The search used up its steps before it converged: don't rely on it.")
    return sentences


def law_sentences(laws: AxisLaws, *, position_unit: str) -> list[str]:
    """What an extended friction law would be worth, in plain words.

    Args:
        laws: Both laws.
        position_unit: SI unit of the log's positions, "m" or "rad".

    Returns:
        Sentences; one alone where the usual law is enough.
    """
    unit = "mm" if position_unit == "m" else "mrad"
    ahead, usual = plain(1e3 * laws.extended_ahead, 3), plain(1e3 * laws.usual_ahead, 3)
    compared = (
        "Fitted to the first 60 % of the record alone, a law with viscous friction of its own "
        f"in each direction predicts the rest to {ahead} {unit} rms, the usual one to {usual} "
        f"{unit}"
    )
    if not laws.extended_is_preferred:
        return [f"{compared}: the usual law is enough."]
    rows = axis_rows(laws.extended, position_unit=position_unit)
    terms = "; ".join(f"{row.meaning} {row.value} {row.unit}" for row in rows)
    error = plain(1e3 * float(laws.extended.open_loop_rmse), 3)
    return [
        f"{compared}: what was held out prefers the extended law.",
        f"The extended law over the whole record, open loop {error} {unit} rms: {terms}. It is "
        "in parameters.json under `extended`.",
    ]
