"""Everything that a calibration comes to, for whoever prints it."""

import dataclasses

from experiments.studies.findings.influence import InfluenceVerdict, influence_verdict
from experiments.studies.findings.knocks import (
    KnockDecay,
    ModelCurve,
    knock_decays,
    model_curves,
)
from experiments.studies.findings.parameters import FrictionForce, friction_forces
from experiments.studies.findings.predictions import Prediction, predictions
from experiments.studies.findings.residuals import Excess, Whiteness, excesses, whiteness
from experiments.studies.findings.tuning import TuningFindings, tuning_findings
from experiments.studies.findings.verdict import verdict
from experiments.studies.findings.words import Words, words_found, words_next, words_sure
from identification.campaign.types import Campaign
from identification.fit.unknowns.measured import MeasuredFit
from identification.knocks.frequency_map import FrequencyMap
from identification.result.estimate import Estimate
from tuning.result.tuning import Tuning

DECAYS = 8
"""Knocks whose decay is kept: more would make a page heavy without telling more."""


@dataclasses.dataclass(frozen=True, eq=False)
class Findings:
    """What a calibration comes to, in numbers and in words."""

    estimate: Estimate
    """The robot's parameters."""
    campaign: Campaign | None
    """The logged runs; None where nothing is to be said of them."""
    frequencies: FrequencyMap | None
    """Natural frequencies; None without."""
    excesses: tuple[Excess, ...]
    """Channels of the fitted runs with more than noise, the worst first."""
    whiteness: Whiteness
    """How white what is left is."""
    predictions: tuple[Prediction, ...]
    """How well the held-out runs are predicted."""
    friction_forces: tuple[FrictionForce, ...]
    """Friction of a carriage at each setting."""
    measured: tuple[MeasuredFit, ...]
    """What was measured otherwise."""
    influence: InfluenceVerdict | None
    """What the runs' influence comes to; None for a single run."""
    decays: tuple[KnockDecay, ...]
    """Fitted decays of the first knocks."""
    model_curves: dict[float, ModelCurve]
    """The model's natural frequencies over the height, by nominal pretension [N]."""
    tuning: TuningFindings | None
    """What gains and shapers come to; None without."""
    verdict: tuple[str, ...]
    """What a fit that has failed comes to, the likeliest cause first; none for a good one."""
    words: Words
    """The summary in words."""
    notes: tuple[str, ...]
    """What a reader should know besides, a sentence each."""


def findings(
    estimate: Estimate,
    *,
    campaign: Campaign | None = None,
    frequencies: FrequencyMap | None = None,
    tuning: Tuning | None = None,
    notes: tuple[str, ...] = (),
) -> Findings:
    """What a calibration comes to.

    Args:
        estimate: The robot's parameters.
        campaign: The logged runs, None if nothing is to be said of them.
        frequencies: Natural frequencies, None without.
        tuning: Gains and shapers, None without.
        notes: What a reader should know besides, a sentence each.

    Returns:
        Numbers and words.
    """
    beyond, held_out = excesses(estimate), predictions(estimate)
    counted, measured = whiteness(estimate), estimate.measured_fits
    forces = friction_forces(estimate)
    mapped = campaign is not None and frequencies is not None
    words = Words(
        words_found(estimate, forces, frequencies),
        words_sure(
            campaign,
            estimate,
            frequencies,
            beyond=beyond,
            counted=counted,
            measured=measured,
            held_out=held_out,
        ),
        words_next(
            estimate,
            frequencies,
            campaign=campaign,
            beyond=beyond,
            held_out=held_out,
            tuned=tuning is not None,
        ),
    )
    return Findings(
        estimate=estimate,
        campaign=campaign,
        frequencies=frequencies,
        excesses=beyond,
        whiteness=counted,
        predictions=held_out,
        friction_forces=forces,
        measured=measured,
        influence=influence_verdict(estimate),
        decays=knock_decays(campaign, frequencies, most=DECAYS) if mapped else (),
        model_curves=model_curves(campaign, estimate, frequencies) if mapped else {},
        tuning=None if tuning is None else tuning_findings(tuning),
        verdict=verdict(estimate, campaign),
        words=words,
        notes=notes,
    )
