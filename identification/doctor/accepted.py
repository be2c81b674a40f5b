"""What of a campaign may be fitted: all that contradicts itself must have been accepted."""

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

from identification.campaign.types import Campaign
from identification.doctor.examine import diagnosis
from identification.doctor.findings import Finding
from identification.doctor.fittable import fittable
from identification.doctor.words import WORDS


class Admission(NamedTuple):
    """Whether a campaign may be fitted."""

    campaign: Campaign | None
    """The campaign as a fit should see it; None if it may not."""
    refused: tuple[Finding, ...]
    """The contradictions that weren't accepted."""


SETTLED = ("start.moving",)
"""Contradictions that no result carries once they are accepted: a run that begins in motion is
fitted as one, or left out, and nothing that rests on it is doubtful."""


def require_identifiers(accept: Sequence[str]) -> None:
    """Refuse what names no finding.

    Args:
        accept: Identifiers of findings.

    Raises:
        ValueError: If there is no such one.
    """
    for identifier in accept:
        if identifier not in WORDS:
            raise ValueError(
                f"`--accept`: no such finding, got {identifier!r}, expected one of: "
                f"{', '.join(WORDS)}. `scdpr check` tells the campaign's own."
            )


def admission(campaign: Campaign, accept: Sequence[str]) -> Admission:
    """A campaign as a fit should see it, if all that contradicts itself was accepted.

    Args:
        campaign: The campaign as it was read.
        accept: Identifiers of the contradictions to go on with.

    Returns:
        The campaign without bad frames, with runs that begin in motion marked and runs in
        pieces where they have a gap, the knocks that were found, and what was accepted; or
        what wasn't.

    Raises:
        ValueError: If there is no such identifier, or nothing is left to fit.
    """
    require_identifiers(accept)
    found = diagnosis(campaign)
    broken = [finding for finding in found.findings if finding.severity != "note"]
    refused = tuple(finding for finding in broken if finding.id not in accept)
    if refused:
        return Admission(None, refused)
    accepted = tuple(
        f"accepted contradiction: {finding}" for finding in broken if finding.id not in SETTLED
    )
    admitted = dataclasses.replace(fittable(campaign, found), accepted=accepted)
    return Admission(admitted, ())
