"""The log doctor before a fit: what contradicts itself isn't fitted unless it is accepted."""

import dataclasses
from collections.abc import Sequence

from experiments.verbs.console import complain
from identification.campaign import Campaign
from identification.doctor.examine import diagnosis
from identification.doctor.fittable import fittable
from identification.doctor.words import WORDS


def examined(campaign: Campaign, accept: Sequence[str], *, verb: str) -> Campaign | None:
    """A campaign that may be fitted, as a fit should see it.

    Args:
        campaign: The campaign as it was read.
        accept: Identifiers of the contradictions to go on with.
        verb: The verb that asks, for its messages.

    Returns:
        The campaign without bad frames and runs that begin in motion, with runs in pieces
        where they have a gap, the knocks that were found, and what was accepted; None if a
        contradiction wasn't, which is then told.

    Raises:
        ValueError: If there is no such identifier, or nothing is left to fit.
    """
    for identifier in accept:
        if identifier not in WORDS:
            raise ValueError(
                f"`--accept`: no such finding, got {identifier!r}, expected one of: "
                f"{', '.join(WORDS)}. `scdpr check` tells the campaign's own."
            )
    found = diagnosis(campaign)
    broken = [finding for finding in found.findings if finding.severity != "note"]
    refused = [finding for finding in broken if finding.id not in accept]
    for finding in refused:
        complain(f"scdpr {verb}: {finding.severity}: {finding}")
    if refused:
        ids = " ".join(dict.fromkeys(finding.id for finding in refused))
        complain(
            f"scdpr {verb}: nothing was fitted. Put it right, or let `scdpr check --mend OUT` "
            f"do it; `--accept {ids}` goes on as it is."
        )
        return None
    accepted = tuple(f"accepted contradiction: {finding}" for finding in broken)
    return dataclasses.replace(fittable(campaign, found), accepted=accepted)
