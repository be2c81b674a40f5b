"""Where results may be written."""

import pathlib


def require_outside(out: pathlib.Path, campaign: pathlib.Path) -> None:
    """Refuse to write results among the logs, where they would pass for a run.

    Args:
        out: Where results shall go.
        campaign: The campaign's folder.

    Raises:
        ValueError: If `out` is the campaign's folder or inside it.
    """
    if out.resolve().is_relative_to(campaign.resolve()):
        raise ValueError(
            f"`--out` must be outside the campaign, got {out} inside {campaign}: a folder in "
            "a campaign is a run. Name another folder."
        )
