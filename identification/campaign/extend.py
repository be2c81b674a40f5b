"""Runs put into a campaign's folder: all of them, or none."""

import dataclasses
from pathlib import Path

from identification.campaign.faults import CampaignError
from identification.campaign.read import CAMPAIGN_FILE, read_rig, survey
from identification.campaign.types import Campaign
from identification.campaign.write import check_name, write_campaign, write_runs
from scdpr_jax.numerics.files.given import DOCUMENT, read_given
from scdpr_jax.numerics.files.scratch import TOGETHER, scratch_folder


def add_runs(campaign: Campaign, path: str | Path) -> None:
    """Put a campaign's runs into a folder, beside those that are there.

    They are written beside their place, read back as a check, and then renamed. A folder with
    a `campaign.toml` keeps it, and every run that it has.

    Args:
        campaign: The runs, and what is known of their rig.
        path: The campaign's folder; made where there is none.

    Raises:
        CampaignError: If a run couldn't be read back.
        FileExistsError: If there is a run of that name already, or a folder without
            `campaign.toml` that isn't empty: `import_campaign` says so before it reads a log.
        ValueError: If the name of a run can't be that of a folder.
    """
    target = Path(path)
    if not (target / CAMPAIGN_FILE).exists():
        write_campaign(campaign, target)
        return
    for run in campaign.runs:
        check_name(run.name)
        if (target / run.name).exists():
            raise FileExistsError(
                f"campaign {target}: there is a run {run.name!r} already, expected none of "
                "that name. Rename it in the mapping; nothing is overwritten."
            )
    with scratch_folder(beside=target) as scratch:
        draft = scratch / "draft"
        draft.mkdir()
        (draft / CAMPAIGN_FILE).write_bytes(read_given(target / CAMPAIGN_FILE, most=DOCUMENT))
        write_runs(campaign, draft)
        faults = survey(draft).all_faults
        if faults:
            raise CampaignError(target, faults)
        with TOGETHER:
            _move_all([draft / run.name for run in campaign.runs], target)


def _move_all(folders: list[Path], target: Path) -> None:
    """Rename folders into another one; if one can't be, take the others back."""
    moved: list[Path] = []
    try:
        for folder in folders:
            folder.rename(target / folder.name)
            moved.append(folder)
    except (OSError, KeyboardInterrupt):
        for folder in moved:
            (target / folder.name).rename(folder)
        raise


def rig_of_folder(path: str | Path) -> Campaign | None:
    """What a folder states of its rig.

    Args:
        path: A campaign's folder.

    Returns:
        The campaign without its runs, None where it has no `campaign.toml`.

    Raises:
        CampaignError: If its `campaign.toml` is at fault.
    """
    folder = Path(path)
    if not (folder / CAMPAIGN_FILE).exists():
        return None
    campaign, faults = read_rig(folder)
    if campaign is None:
        raise CampaignError(folder, faults)
    return dataclasses.replace(campaign, runs=())
