"""`scdpr import`: a mapping's runs, written into a campaign's folder."""

from collections.abc import Sequence
from pathlib import Path

from identification.bring.mapping.document import CampaignDocument, read_mapping
from identification.bring.runs import import_runs
from identification.campaign.extend import add_runs, rig_of_folder
from identification.campaign.faults import CampaignError, Fault
from identification.campaign.read import CAMPAIGN_FILE, campaign_of, with_camera_sigma
from identification.campaign.types import Campaign

_TOLD = 11
"""Lines that the faults of a message have at most."""


def import_campaign(mapping: str | Path, into: str | Path) -> Campaign:
    """Import the runs of a mapping into a campaign's folder.

    Args:
        mapping: The mapping.
        into: The campaign's folder; made where there is none. One that has a `campaign.toml`
            keeps it, and its runs.

    Returns:
        The imported runs, with what is known of the rig.

    Raises:
        CampaignError: If anything is missing or wrong, with all of it; nothing is written.
        FileExistsError: If there is a run of such a name already.
    """
    campaign = mapped_campaign(mapping, into)
    add_runs(campaign, into)
    return campaign


def mapped_campaign(mapping: str | Path, into: str | Path | None = None) -> Campaign:
    """The runs of a mapping, not written yet.

    Args:
        mapping: The mapping.
        into: The folder that they shall go to, for its `campaign.toml`; None for none.

    Returns:
        The runs, with what is known of the rig.

    Raises:
        CampaignError: If anything is missing or wrong, with all of it.
    """
    path = Path(mapping)
    document, faults = read_mapping(path)
    if document is None:
        raise CampaignError(path, told(faults), what="mapping")
    folder = path.parent if into is None else Path(into)
    stated = campaign_of(document.campaign or CampaignDocument(), folder.resolve(), ())
    there = None if into is None else rig_of_folder(into)
    faults = () if there is None else _contradiction(there, document.campaign, path)
    faults += () if into is None else _taken(Path(into), [run.name for run in document.run])
    rig = stated if there is None else there
    imported = import_runs(
        document, home=path.parent, file=str(path), counts_per_rev=rig.counts_per_rev
    )
    faults = (*faults, *imported.faults)
    if faults:
        raise CampaignError(path, told(faults), what="mapping")
    return Campaign(
        name=rig.name,
        runs=with_camera_sigma(document.campaign or CampaignDocument(), imported.runs),
        counts_per_rev=rig.counts_per_rev,
        robot=rig.robot,
        sensors=rig.sensors,
    )


def told(faults: Sequence[Fault]) -> tuple[Fault, ...]:
    """Faults as one message holds them.

    Args:
        faults: All faults.

    Returns:
        The first ten, and one that counts the rest.
    """
    if len(faults) <= _TOLD:
        return tuple(faults)
    more = Fault(
        what=f"and {len(faults) - _TOLD + 1} more",
        remedy="Mend those above and try again: they often have one cause.",
    )
    return (*faults[: _TOLD - 1], more)


def _taken(folder: Path, names: Sequence[str]) -> tuple[Fault, ...]:
    """Why runs can't be put into a folder."""
    taken = [name for name in names if (folder / name).exists()] if folder.is_dir() else []
    if taken:
        got = f"{taken[0]!r}" + (f" and {len(taken) - 1} more" if len(taken) > 1 else "")
        what, expected = "a run of that name is there already", "a name of its own for each run"
    elif folder.exists() and not folder.is_dir():
        what, got, expected = "the campaign isn't a folder", "a file", "a folder, or nothing"
    elif folder.is_dir() and any(folder.iterdir()) and not (folder / CAMPAIGN_FILE).exists():
        what, got = "a folder that is no campaign", "files, and no campaign.toml"
        expected = f"a folder with {CAMPAIGN_FILE}, an empty one, or none"
    else:
        return ()
    remedy = "Rename the run, or import into another folder; nothing is overwritten."
    return (Fault(what=what, file=str(folder), got=got, expected=expected, remedy=remedy),)


def _contradiction(
    there: Campaign, said: CampaignDocument | None, path: Path
) -> tuple[Fault, ...]:
    """What a mapping and the campaign's own file say differently."""
    counts = None if said is None else said.counts_per_rev
    if counts is None or counts == there.counts_per_rev:
        return ()
    return (
        Fault(
            what="counts_per_rev of the mapping isn't the campaign's",
            file=str(path),
            key="campaign.counts_per_rev",
            got=f"{counts:g}, and {there.counts_per_rev} in its campaign.toml",
            expected="one rig",
            remedy="Correct one of them, or import into another folder.",
        ),
    )
