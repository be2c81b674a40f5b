"""Runs put into a campaign's folder: all of them, or none."""

import dataclasses
import os
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path

from identification.campaign.faults import CampaignError
from identification.campaign.read import CAMPAIGN_FILE, read_rig, survey
from identification.campaign.tables.text_file import read_text
from identification.campaign.types import Campaign
from identification.campaign.write import (
    camera_sigma_table,
    check_name,
    write_campaign,
    write_runs,
)
from scdpr_jax.numerics.files import write_whole
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
        stated = [
            state_camera(draft, run.name, run.camera_sigma)
            for run in campaign.runs
            if run.camera_sigma
        ]
        there = [each.name for each in target.iterdir()]
        faults = survey(draft, absent=there).all_faults
        if faults:
            raise CampaignError(target, faults)
        with TOGETHER:
            _move_all([draft / run.name for run in campaign.runs], target)
            if any(stated):
                os.replace(draft / CAMPAIGN_FILE, target / CAMPAIGN_FILE)


def state_camera(path: str | Path, name: str, sigma: Mapping[str, float]) -> bool:
    """State the standard deviations of a run's camera in `campaign.toml`.

    The rest of the file stays as it is to the letter, comments included.

    Args:
        path: The campaign's folder.
        name: Name of the run's folder.
        sigma: Standard deviations of its columns [m, rad].

    Returns:
        Whether it was done; not so where the file isn't there, isn't TOML, or states them in
        a way that isn't a table of its own.
    """
    file = Path(path) / CAMPAIGN_FILE
    if not file.is_file():
        return False
    text, fault = read_text(file, most=DOCUMENT)
    if fault is not None:
        return False
    table = camera_sigma_table(name, sigma)
    edited = _with_table(text, table)
    try:
        before, after = tomllib.loads(text), tomllib.loads(edited)
    except tomllib.TOMLDecodeError:
        return False
    runs = before.setdefault("sensors", {}).setdefault("runs", {})
    runs[name] = tomllib.loads("\n".join(table[1:]))
    if after != before:
        return False
    write_whole(file, edited)
    return True


def _with_table(text: str, table: Sequence[str]) -> str:
    """A text with a table in the place of the one of its heading, or at its end."""
    lines = text.splitlines()
    first = next((k for k, line in enumerate(lines) if line.strip() == table[0]), None)
    if first is None:
        return "\n".join([*lines, "", *table, ""])
    rest = enumerate(lines[first + 1 :], start=first + 1)
    ends = (k for k, line in rest if not line.strip() or line.lstrip().startswith("["))
    last = next(ends, len(lines))
    return "\n".join([*lines[:first], *table, *lines[last:], ""])


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
