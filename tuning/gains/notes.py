"""What a reader of a tuning should know, in whole sentences."""

from collections.abc import Sequence

import numpy as np

from tuning.gains.regional import NONE
from tuning.regions.cells import Frequencies, other_modes
from tuning.result.prediction import PredictedLegs, Prediction
from tuning.result.regional_shaper import RegionalShaper
from tuning.result.tuning import FittedSetting

LITTLE = 0.6
"""Share of the vibration from which gains and shapers are said to gain little [1]."""
_JUDGED = {
    "residual_vibration": "residual vibration",
    "resting_error": "resting error",
    "largest_error": "largest error against the commanded reference",
    "rms_error": "rms error against the commanded reference",
    "largest_original_error": "largest error against the unshaped reference (a shaper delays)",
}
"""Metrics that a note tells of where they became worse, by their field's name."""


def notes_of(
    knocks: Frequencies,
    fitted: Sequence[FittedSetting],
    shapers: Sequence[RegionalShaper],
    legs: PredictedLegs,
    predicted: Sequence[Prediction],
) -> tuple[str, ...]:
    """The notes of a tuning.

    Args:
        knocks: The measured map.
        fitted: The robot at every setting.
        shapers: The regions' shapers.
        legs: What they are predicted to do.
        predicted: The manoeuvres before and after.

    Returns:
        Sentences.
    """
    return (
        *_other_modes(knocks, fitted),
        *_modelled(shapers),
        *_gain(shapers, legs),
        *_worse(predicted),
    )


def _other_modes(knocks: Frequencies, fitted: Sequence[FittedSetting]) -> list[str]:
    return [
        f"The knock at x {knocks.x[row]:.2f} m, y {knocks.y[row]:.2f} m and {each.pretension:g}"
        f" N rings at {knocks.frequency[row]:.2f} Hz, in another mode than the sway that "
        "shapers are for: it says nothing of them. Knock there anew, with the drives held."
        for each in fitted
        for row in other_modes(knocks, each.robot, pretension=each.pretension)
    ]


def _modelled(shapers: Sequence[RegionalShaper]) -> list[str]:
    modelled = sum(not shaper.measured for shaper in shapers)
    if not modelled:
        return []
    return [
        f"{modelled} of {len(shapers)} regions have no knock: their frequency is the "
        "model's, with both carriages held by friction. Knock there to measure it."
    ]


def _gain(shapers: Sequence[RegionalShaper], legs: PredictedLegs) -> list[str]:
    """What gains and shapers are worth, what they cost, and why there isn't more."""
    count, worse = len(legs.after.vibration), round(legs.worse * len(legs.after.vibration))
    resting = [1e3 * float(np.median(e.resting_error)) for e in (legs.before, legs.after)]
    longer = max(float(shaper.shaper.duration) for shaper in shapers)
    left, worst = (round(100 * number) for number in (legs.share, legs.worst_share))
    notes = [
        f"Over {count} random legs gains and shapers are predicted to leave {left} % of the "
        f"vibration under Eq. (25), {worst} % of that of the robot that they serve worst; "
        f"legs that shake more than before: {worse}. The robot rests {resting[1]:.1f} mm from "
        f"its target where it rested {resting[0]:.1f} mm (median). Legs arrive up to "
        f"{longer:.2f} s later."
    ]
    poor = [shaper for shaper in shapers if shaper.share > LITTLE or shaper.kind == NONE]
    if poor or legs.share > LITTLE:
        notes.append(
            f"In {len(poor)} of {len(shapers)} regions they gain little: what is left comes "
            "from the carriages' friction, where the upper one breaks away and sticks, which "
            "no shaper undoes. A planned leg (`scdpr plan`) leaves less."
        )
    return notes


def _worse(predicted: Sequence[Prediction]) -> list[str]:
    """What a manoeuvre pays for the rest."""
    notes = []
    for prediction in predicted:
        worse = [
            words
            for name, words in _JUDGED.items()
            if getattr(prediction.after, name) > getattr(prediction.before, name)
        ]
        if worse:
            notes.append(f"{prediction.name}: worse than before in {', '.join(worse)}.")
    return notes
