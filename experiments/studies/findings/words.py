"""The summary in words: what was found, how far to trust it, and what to do next."""

import dataclasses

from experiments.page.number_text import plain
from experiments.studies.findings.knocks import frequency_sentence
from experiments.studies.findings.models import model_sentences
from experiments.studies.findings.parameters import (
    FrictionForce,
    estimated,
    friction_sentence,
    parameter_sentence,
)
from experiments.studies.findings.plausibility import (
    contradiction_sentence,
    implausible,
    ringing_doubts,
    settings_alike,
)
from experiments.studies.findings.predictions import Prediction, prediction_sentence
from experiments.studies.findings.residuals import (
    Excess,
    Whiteness,
    excess_sentence,
    whiteness_sentence,
)
from experiments.studies.findings.verdict import doubts
from identification.campaign.types import Campaign
from identification.fit.unknowns.measured import MeasuredFit
from identification.knocks.frequency_map import FrequencyMap
from identification.result.estimate import Estimate

_LISTED = 3  # runs that are named one by one


@dataclasses.dataclass(frozen=True)
class Words:
    """The summary: what was found, how sure, and what to do next."""

    found: tuple[str, ...]
    """What was found, a sentence each; the parameters first, one each."""
    sure: tuple[str, ...]
    """How far it can be trusted."""
    next: tuple[str, ...]
    """What to do next."""


def words_found(
    estimate: Estimate, forces: tuple[FrictionForce, ...], frequencies: FrequencyMap | None
) -> tuple[str, ...]:
    """What was found, in words.

    Args:
        estimate: The estimate.
        forces: Its friction forces.
        frequencies: Natural frequencies, None without.

    Returns:
        A sentence each.
    """
    return (
        *(parameter_sentence(parameter) for parameter in estimated(estimate)),
        *map(friction_sentence, forces),
        *(() if frequencies is None else (frequency_sentence(frequencies),)),
    )


def words_sure(
    campaign: Campaign | None,
    estimate: Estimate,
    frequencies: FrequencyMap | None,
    *,
    beyond: tuple[Excess, ...],
    counted: Whiteness,
    measured: tuple[MeasuredFit, ...],
    held_out: tuple[Prediction, ...],
) -> tuple[str, ...]:
    """How far the estimate can be trusted, in words.

    Args:
        campaign: The campaign, None if nothing is to be said of its clocks and faults.
        estimate: The estimate.
        frequencies: Natural frequencies, None without.
        beyond: Channels with more than noise.
        counted: How white the residuals are.
        measured: What was measured otherwise.
        held_out: How well the held-out runs are predicted.

    Returns:
        A sentence each.
    """
    sentences = (
        excess_sentence(estimate, beyond),
        whiteness_sentence(counted),
        *model_sentences(estimate),
        *(contradiction_sentence(fit) for fit in measured if fit.is_contradicted),
        *_untold(estimate),
        *map(prediction_sentence, held_out),
        *_ending(estimate),
        *doubts(estimate),
        *settings_alike(estimate),
        *(() if frequencies is None else ringing_doubts(frequencies, estimate.robot)),
    )
    if campaign is None:
        return sentences
    return (
        *sentences,
        *implausible(estimate, campaign),
        *_clocks(campaign, estimate),
        *_begun(campaign, estimate),
        *_skipped(campaign),
    )


def words_next(
    estimate: Estimate,
    frequencies: FrequencyMap | None,
    *,
    campaign: Campaign | None,
    beyond: tuple[Excess, ...],
    held_out: tuple[Prediction, ...],
    tuned: bool,
) -> tuple[str, ...]:
    """What to do next, in words.

    Args:
        estimate: The estimate.
        frequencies: Natural frequencies, None without.
        campaign: The campaign, None if nothing is known of its runs.
        beyond: Channels with more than noise.
        held_out: How well the held-out runs are predicted.
        tuned: Whether gains and shapers were made from it.

    Returns:
        A sentence each.
    """
    if not estimate.fits:
        return (
            "Find the cause before anything else: correct or leave out what the verdict names, "
            "and fit again. The residuals of the worst runs below show what is missed.",
        )
    steps = []
    for parameter in estimated(estimate):
        name = parameter.name.replace("_", " ")
        if parameter.status in ("weak", "unidentifiable") and not estimate.accepted:
            steps.append(f"Log runs that excite the {name}: it is {parameter.status} so far.")
        if parameter.status == "at_bound" and beyond:
            steps.append(
                f"Ask whether the {name} is zero indeed, or the model lacks something."
            )
    if beyond:
        steps.append(
            "Look at the residuals of the worst run below: a step points to friction, a sine "
            "to stiffness or mass, a slope to a drive or a clock."
        )
    if not held_out:
        steps.append("Hold a run out next time, to see how well the model predicts.")
    if frequencies is None:
        steps.append(_knocks(campaign))
    if tuned:
        steps.append(
            "Set the gains and shapers on the rig, starting with a slow manoeuvre, log it, and "
            "hold it against the prediction."
        )
    elif not steps:
        steps.append("Use the parameters: tune the controller and the shapers with them.")
    return tuple(steps)


def _knocks(campaign: Campaign | None) -> str:
    """How to come by natural frequencies, with the knocks that there are."""
    runs = () if campaign is None else campaign.runs
    knocks = sum(run.kind == "pseudo_impulse" for run in runs)
    if not knocks:
        return "Log knocks over the workspace: shapers need the natural frequencies."
    there = "1 knock" if knocks == 1 else f"{knocks} knocks"
    return (
        f"Map the natural frequencies of the campaign's {there} with `scdpr frequencies`: "
        "shapers need them."
    )


def _untold(estimate: Estimate) -> tuple[str, ...]:
    """Why a quantity can't be told, or hardly."""
    badly = [p for p in estimated(estimate) if p.status in ("weak", "unidentifiable")]
    reasons = [estimate.identifiability.reason(p.name, p.setting) for p in badly]
    return tuple(dict.fromkeys(reasons))


def _ending(estimate: Estimate) -> tuple[str, ...]:
    if estimate.fit.ended == "converged" or not estimate.fits:
        return ()
    reason = {
        "stalled": "ended where a run only just stops or doesn't, at a kink of the misfit",
        "unfinished": "used up its iterations before its stopping rule was met",
    }.get(estimate.fit.ended, f"ended as {estimate.fit.ended}")
    return (f"The fit {reason}: the standard errors may be too small.",)


def _clocks(campaign: Campaign, estimate: Estimate) -> tuple[str, ...]:
    filmed = [
        run
        for run in campaign.runs
        if run.camera is not None and run.name in estimate.circumstances
    ]
    offsets = {
        run.name: 1e3 * float(estimate.circumstances[run.name].clock_offset)
        for run in filmed
        if run.clock_offset is None
    }
    drifts = [1e6 * float(estimate.circumstances[run.name].clock_drift) for run in filmed]
    listed = "; ".join(f"{name} {plain(offset, 3)} ms" for name, offset in offsets.items())
    if len(offsets) > _LISTED:
        low, high = min(offsets.values()), max(offsets.values())
        listed = f"{plain(low, 3)} to {plain(high, 3)} ms in {len(offsets)} runs"
    sentences = []
    if offsets:
        sentences.append(
            f"The camera's clock was unknown and estimated, camera minus drive: {listed}."
        )
    if estimate.options.clock_drifts and drifts:
        sentences.append(
            f"By the fit the cameras' clocks run {plain(min(drifts), 3)} to "
            f"{plain(max(drifts), 3)} ppm faster than the drives'."
        )
    return tuple(sentences)


def _begun(campaign: Campaign, estimate: Estimate) -> tuple[str, ...]:
    """How what begins in motion began: the end-effector's velocity, and the drives'."""
    begun = []
    for run in campaign.runs:
        circumstances = estimate.circumstances.get(run.name)
        if not run.in_motion or circumstances is None or circumstances.beginning is None:
            continue
        start = circumstances.beginning
        drives = [plain(float(s), 3) for s in (start.drive_1_speed, start.drive_2_speed)]
        body = (
            "" if run.kind == "motor_step" else f"{plain(1e3 * float(start.speed), 3)} mm/s, "
        )
        begun.append(f"{run.name} {body}drives {drives[0]} and {drives[1]} rad/s")
    if not begun:
        return ()
    more = f"; and {len(begun) - _LISTED} more" if len(begun) > _LISTED else ""
    listed = "; ".join(begun[:_LISTED]) + more
    return (f"Start velocities were estimated of what begins in motion: {listed}.",)


def _skipped(campaign: Campaign) -> tuple[str, ...]:
    return tuple(
        f"Run {name} was skipped: {faults[0] if faults else 'no reason given'}"
        for name, faults in campaign.skipped
    )
