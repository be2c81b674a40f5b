"""What was found about a motor-driven axis, in words and as a table's rows."""

import math
from collections.abc import Sequence

import numpy as np

from experiments.page.number_text import percent, plain, readable_unit, rounded
from experiments.reports.parameter_table import Row
from identification.axis.estimate import DriveAxisEstimate
from identification.axis.law import AxisLaws

MEANING = {
    "mass": ("M", "", "moving mass, the motor's inertia with it"),
    "viscous": ("F", "v", "viscous friction"),
    "coulomb": ("F", "c", "Coulomb friction"),
    "offset": ("o", "", "constant force against the drive"),
    "viscous_difference": ("ΔF", "v", "viscous friction forwards minus backwards"),
}
"""Symbol with its index, and what it is, of each quantity of an axis."""


def axis_verdict(laws: AxisLaws) -> tuple[str, ...]:
    """What a law that has failed, or that doesn't hold throughout, comes to, in words.

    Args:
        laws: Both laws.

    Returns:
        Sentences; none for a law that fits.
    """
    estimate = laws.preferred
    sentences = []
    if not estimate.fits:
        unit, scale = _shown(estimate.position_unit)
        error = plain(scale * float(estimate.open_loop_rmse), 3)
        share = percent(float(estimate.open_loop_rmse) / _motion(estimate))
        sentences.append(
            f"THE LAW DOES NOT FIT: open loop it is off by {error} {unit} rms, {share} of the "
            "motion. No value has an interval. Check the gain, that voltage and position "
            "belong together, and that nothing else moves or holds the axis."
        )
    if estimate.changes:
        listed = "; ".join(
            f"{MEANING[change.name][2]} {plain(change.first, 3)} in the first half, "
            f"{plain(change.second, 3)} {readable_unit(estimate.units[change.name])} in the "
            "second"
            for change in estimate.changes
        )
        sentences.append(
            f"ONE LAW DOESN'T FIT THE WHOLE RECORD: {listed}. Something changed on the way: "
            "the load, the temperature, a stop. Fit the halves by themselves."
        )
    return tuple(sentences)


def axis_rows(estimate: DriveAxisEstimate) -> list[Row]:
    """The lines of an axis's table of parameters.

    Args:
        estimate: The estimate.

    Returns:
        One for each parameter.
    """
    rows = []
    for index, name in enumerate(estimate.names):
        number = float(getattr(estimate.parameters, name))
        half = 1.96 * float(getattr(estimate.sigma, name))
        low, high = (float(end) for end in estimate.interval95[index])
        base, lower_index, meaning = MEANING[name]
        known = math.isfinite(half)
        step = half if known else 1e-2 * abs(number)
        rows.append(
            Row(
                name=name,
                symbol=(base, lower_index),
                meaning=meaning,
                setting="",
                value=rounded(number, step),
                low=rounded(low, half) if known else "",
                high=rounded(high, half) if known else "",
                relative=percent(half / abs(number)) if half < abs(number) else "",
                unit=readable_unit(estimate.units[name]),
                status=estimate.status[index].replace("_", " "),
                truth="",
                error="",
                covered="",
            )
        )
    return rows


def axis_sentences(estimate: DriveAxisEstimate) -> list[str]:
    """What an axis's estimate comes to, in plain words.

    Args:
        estimate: The estimate.

    Returns:
        Sentences: one for each parameter, then how far to trust them.
    """
    unit, scale = _shown(estimate.position_unit)
    error, motion = float(estimate.open_loop_rmse), _motion(estimate)
    sentences = [_parameter_sentence(row) for row in axis_rows(estimate)]
    sentences += untold_sentences(estimate)
    sentences.append(
        f"Open loop over the whole record the axis is predicted to {plain(scale * error, 3)} "
        f"{unit} rms, {percent(error / motion)} of its {plain(scale * motion, 3)} {unit} of "
        "motion."
    )
    ahead = (
        f"Beside the open loop, predictions over {_listed(estimate.horizons)} s were fitted. "
        if estimate.horizons
        else ""
    )
    sentences.append(
        f"{ahead}{estimate.agreeing_starts} of {estimate.starts} starts of the search agree; "
        f"the residuals are correlated over {plain(float(estimate.memory))} s, which the "
        "intervals take into account, as they do what horizons and halves disagree by."
    )
    if not estimate.converged:
        sentences.append("The search used up its steps before it converged: don't rely on it.")
    return sentences


def untold_sentences(estimate: DriveAxisEstimate) -> list[str]:
    """What the log can't tell, and what it tells instead, in plain words.

    Args:
        estimate: The estimate.

    Returns:
        A sentence for each combination that isn't told.
    """
    sentences = []
    together = estimate.sum_of_frictions()
    for combination in estimate.untold:
        sentence = (
            f"The log can't tell {combination.text()}: all that is plausible of it moves the "
            f"axis by {percent(combination.share)} of its motion."
        )
        if together is not None:
            value, half = together[0], 1.96 * together[1]
            unit = readable_unit(estimate.units["coulomb"])
            sentence += (
                f" It tells Coulomb friction and offset together, {rounded(value, half)} ± "
                f"{rounded(half, half)} {unit} (95 %), and neither alone: log motion in both "
                "directions."
            )
        sentences.append(sentence)
    return sentences


def law_sentences(laws: AxisLaws) -> list[str]:
    """What an extended friction law would be worth, in plain words.

    Args:
        laws: Both laws.

    Returns:
        Sentences; one alone where the usual law is enough.
    """
    unit, scale = _shown(laws.usual.position_unit)
    if math.isnan(laws.usual_ahead + laws.extended_ahead):
        return ["The record is too short, or too still, to hold a part of it out."]
    ahead, usual = plain(scale * laws.extended_ahead, 3), plain(scale * laws.usual_ahead, 3)
    compared = (
        "Fitted to the first 60 % of the record alone, a law with viscous friction of its own "
        f"in each direction predicts the rest to {ahead} {unit}, the usual one to {usual} "
        f"{unit} (geometric mean over the horizons)"
    )
    if not laws.extended_is_preferred:
        return [f"{compared}: the usual law is enough."]
    terms = "; ".join(
        f"{row.meaning} {row.value} {row.unit}" for row in axis_rows(laws.extended)
    )
    error = plain(scale * float(laws.extended.open_loop_rmse), 3)
    return [
        f"{compared}: what was held out prefers the extended law.",
        f"The extended law over the whole record, open loop {error} {unit} rms: {terms}. It is "
        "in parameters.json under `extended`.",
    ]


def _parameter_sentence(row: Row) -> str:
    value = f"{row.meaning[0].upper()}{row.meaning[1:]}: {row.value} {row.unit}"
    if not row.low:
        return f"{value} ({row.status})."
    return f"{value}, 95 % from {row.low} to {row.high} ({row.status})."


def _shown(position_unit: str) -> tuple[str, float]:
    """The unit that positions are told in, and how many there are in one of SI."""
    return ("mm" if position_unit == "m" else "mrad"), 1e3


def _motion(estimate: DriveAxisEstimate) -> float:
    return float(np.ptp(np.asarray(estimate.positions)))


def _listed(numbers: Sequence[float]) -> str:
    texts = [plain(number, 2) for number in numbers]
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} and {texts[-1]}"
