"""Many campaigns in one call: each failure is a row with its reason, never a lost batch."""

import dataclasses
from collections.abc import Callable, Iterable, Iterator

from identification.campaign.types import Campaign
from identification.result.estimate import Estimate
from identification.result.estimation import estimate


@dataclasses.dataclass(frozen=True, eq=False)
class Row:
    """What became of one campaign."""

    name: str
    """Name of the campaign."""
    estimate: Estimate | None
    """Its estimate, None if there is none."""
    failure: str
    """Why there is none; empty if there is one."""


def estimate_each(
    campaigns: Iterable[Campaign], *, fit: Callable[[Campaign], Estimate] = estimate
) -> Iterator[Row]:
    """Estimates of many campaigns, one after the other.

    Campaigns whose runs have the same shapes share all that is compiled.

    Args:
        campaigns: The campaigns.
        fit: How one is fitted: `estimate`, `select`, or either with some options.

    Yields:
        A row for each, in their order.
    """
    for campaign in campaigns:
        try:
            fitted = fit(campaign)
        except (ValueError, FloatingPointError) as error:
            yield Row(campaign.name, None, str(error))
        else:
            yield Row(campaign.name, fitted, "")
