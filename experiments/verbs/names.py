"""Names of quantities and runs as they are given to a verb."""

from collections.abc import Sequence

from identification.campaign import Campaign
from identification.campaign.abbreviation import full_names


def free_quantities(given: Sequence[str]) -> tuple[str, ...]:
    """Quantities to estimate.

    Args:
        given: What follows `--free`.

    Returns:
        Their names.

    Raises:
        ValueError: If one stands for no quantity, or for several.
    """
    from scdpr_jax.robot.stated.names import EVERY_QUANTITY

    known = [quantity.name for quantity in EVERY_QUANTITY]
    return full_names(given, known, argument="--free", what="quantity")


def run_names(campaign: Campaign, given: Sequence[str]) -> tuple[str, ...]:
    """Runs to predict instead of fitting them.

    Args:
        campaign: The campaign.
        given: What follows `--hold-out`.

    Returns:
        Their names.

    Raises:
        ValueError: If one stands for no run, or for several.
    """
    known = [run.name for run in campaign.runs]
    return full_names(given, known, argument="--hold-out", what="run")
