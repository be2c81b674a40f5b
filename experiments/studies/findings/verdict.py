"""The verdict on a fit that has failed: what it means, and what is the likeliest cause."""

from collections.abc import Sequence

from experiments.page.coordinates import COORDINATES
from experiments.page.number_text import percent, plain
from identification.campaign.types import Campaign
from identification.doctor.examine import examine
from identification.doctor.words import WORDS
from identification.fit.comparison import ENCODERS
from identification.judge.verdict import Unexplained
from identification.result.estimate import Estimate

_LISTED = 3  # channels that are named one by one

_TELLING = (
    "gap.drive",
    "start.moving",
    "time.jump",
    "knock.missing",
    "knock.wrong",
    "label.kind",
    "swapped_marker",
    "lost_as_value",
)
"""Notes of the log doctor that may be why a run isn't explained, the likeliest first."""


def verdict(estimate: Estimate, campaign: Campaign | None) -> tuple[str, ...]:
    """What a fit that has failed comes to, in words.

    Args:
        estimate: The estimate.
        campaign: The campaign, None if nothing is to be said of its logs.

    Returns:
        Sentences, the first of which names the likeliest cause; none for a fit that is good.
    """
    if estimate.fits:
        return ()
    channels = estimate.unexplained
    worst = "; ".join(map(_channel, channels[:_LISTED]))
    return (
        f"THE MODEL DOES NOT FIT. The likeliest cause: {_cause(estimate, campaign)}",
        f"{len(channels)} channels aren't explained by any model that was tried. The worst: "
        f"{worst}.",
        "No value has an interval: what the model errs by, the values err by, and nothing here "
        "tells how far. Gains, shapers and plans aren't made from such a fit, unless by "
        "--force.",
    )


def doubts(estimate: Estimate) -> tuple[str, ...]:
    """What a good fit rests on where a contradiction was accepted, in words.

    Args:
        estimate: The estimate.

    Returns:
        A sentence, or none.
    """
    if not estimate.accepted or not estimate.fits:
        return ()
    return (
        f"The sensors contradict each other ({_accepted_ids(estimate)}), which was accepted: "
        "no value is called more than weakly identified, though the residuals are noise.",
    )


def _cause(estimate: Estimate, campaign: Campaign | None) -> str:
    if estimate.accepted:
        identifier = _accepted_ids(estimate).split(", ")[0]
        return (
            f"the contradiction that was accepted, {identifier}. {WORDS[identifier].cause} "
            f"{WORDS[identifier].remedy}"
        )
    channels = estimate.unexplained
    runs = tuple(dict.fromkeys(channel.run for channel in channels))
    if campaign is not None and (noted := _noted(campaign, runs)):
        return noted
    return _pattern(
        channels, runs, fitted=sum(not run.held_out for run in estimate.comparisons)
    )


def _noted(campaign: Campaign, runs: Sequence[str]) -> str:
    """What the log doctor noted of the runs that aren't explained, empty for nothing."""
    noted = [each for each in examine(campaign) if set(each.runs) & set(runs)]
    for identifier in _TELLING:
        for finding in noted:
            if finding.id == identifier:
                return str(finding)
    return ""


def _pattern(channels: Sequence[Unexplained], runs: Sequence[str], *, fitted: int) -> str:
    """What the channels that aren't explained have in common."""
    names = tuple(dict.fromkeys(channel.channel for channel in channels))
    if len(runs) == 1 and fitted > 1:
        return (
            f"something was different in {runs[0]}, the only run that isn't explained: another "
            "label, a hand on the rig, a knock that isn't logged. Leave it out and fit again."
        )
    if len(names) == 1:
        return (
            f"{names[0]}: no other channel is left unexplained. Check its sensor, its unit and "
            "its sign."
        )
    if all(name in ENCODERS for name in names):
        return (
            "what the drives were commanded, or their encoders: the camera is explained. Check "
            "the unit and the sign of voltages and angles, and the plugs."
        )
    if not any(name in ENCODERS for name in names):
        return (
            "the camera, its calibration or its clock, or cables that stretch: the encoders "
            "are explained. Measure a known distance in the picture, and check the clock."
        )
    return (
        "a slip that the sensors' comparison doesn't tell (a unit, a plug, a label), or a rig "
        "that has what no model here has: slack, a bent guide, another friction. Fit the runs "
        "of one kind by themselves, and look at the first that fails."
    )


def _channel(channel: Unexplained) -> str:
    symbol = COORDINATES[channel.channel].symbol
    of_motion = f", {percent(channel.share)} of its motion" if channel.share < 10 else ""
    return f"{channel.run}, {symbol}: {plain(channel.ratio)} times the noise{of_motion}"


def _accepted_ids(estimate: Estimate) -> str:
    """Identifiers of the accepted contradictions, which their words begin with."""
    words = (text.removeprefix("accepted contradiction: ") for text in estimate.accepted)
    return ", ".join(dict.fromkeys(text.split(",")[0] for text in words))
