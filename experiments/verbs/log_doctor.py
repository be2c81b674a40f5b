"""The log doctor before a fit: what contradicts itself isn't fitted unless it is accepted."""

from collections.abc import Sequence

from experiments.verbs.console import complain
from identification.campaign import Campaign
from identification.doctor.accepted import admission


def examined(campaign: Campaign, accept: Sequence[str], *, verb: str) -> Campaign | None:
    """A campaign that may be fitted, as a fit should see it.

    Args:
        campaign: The campaign as it was read.
        accept: Identifiers of the contradictions to go on with.
        verb: The verb that asks, for its messages.

    Returns:
        The campaign as `admission` has it; None if a contradiction wasn't accepted, which is
        then told.

    Raises:
        ValueError: If there is no such identifier, or nothing is left to fit.
    """
    admitted, refused = admission(campaign, accept)
    for finding in refused:
        complain(f"scdpr {verb}: {finding.severity}: {finding}")
    if refused:
        ids = " ".join(dict.fromkeys(finding.id for finding in refused))
        complain(
            f"scdpr {verb}: nothing was fitted. Put it right, or let `scdpr check --mend OUT` "
            f"do it; `--accept {ids}` goes on as it is."
        )
    return admitted
