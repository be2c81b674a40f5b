"""Reading a campaign: all of it, or one error with all its faults."""

import dataclasses
import difflib
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from identification.campaign.faults import CampaignError, Fault
from identification.campaign.quantities import format_quantity
from identification.campaign.schema import CampaignDocument, RunDocument, read_model
from identification.campaign.streams import (
    ACCELEROMETER_FILE,
    CAMERA_FILE,
    DRIVE_FILE,
    EPOCH,
    read_accelerometer,
    read_camera,
    read_drive,
)
from identification.campaign.tables.document import row_of
from identification.campaign.tables.inside import foreign, linked
from identification.campaign.tables.text_file import read_text
from identification.campaign.types import (
    Campaign,
    DriveStream,
    Initial,
    Knock,
    Run,
    default_sensors,
)
from scdpr_jax.numerics.files.given import DOCUMENT
from scdpr_jax.numerics.files.harmless import represented
from scdpr_jax.provenance import hash_of

CAMPAIGN_FILE = "campaign.toml"
"""Name of the file about the rig."""
RUN_FILE = "run.toml"
"""Name of the file about a run."""
_FILES = (RUN_FILE, DRIVE_FILE, CAMERA_FILE, ACCELEROMETER_FILE)


@dataclasses.dataclass(frozen=True, eq=False)
class RunReading:
    """What came of reading one run's folder."""

    name: str
    """Name of the folder."""
    run: Run | None
    """The run, None if there are faults."""
    faults: tuple[Fault, ...]
    """What is wrong with it."""


@dataclasses.dataclass(frozen=True, eq=False)
class Reading:
    """What came of reading a campaign's folder."""

    faults: tuple[Fault, ...]
    """What is wrong with the folder itself and with `campaign.toml`."""
    campaign: Campaign | None
    """The campaign with the good runs, None if `campaign.toml` is at fault."""
    runs: tuple[RunReading, ...]
    """Every run's folder."""

    @property
    def all_faults(self) -> tuple[Fault, ...]:
        """What is wrong with the campaign and with all its runs."""
        return self.faults + tuple(fault for run in self.runs for fault in run.faults)


def read_campaign(path: str | Path, *, skip_bad_runs: bool = False) -> Campaign:
    """A campaign of logged runs.

    Args:
        path: The campaign's folder.
        skip_bad_runs: Whether to go on without the runs that have faults; their names and
            faults are in the result's `skipped`.

    Returns:
        The campaign in SI units and radians.

    Raises:
        CampaignError: If anything is wrong with `campaign.toml`, with a run that isn't
            skipped, or with all runs; it lists every fault. A `ValueError`.
    """
    reading = survey(path)
    bad = tuple((run.name, run.faults) for run in reading.runs if run.faults)
    campaign = reading.campaign
    unusable = campaign is None or reading.faults or not campaign.runs
    if unusable or (bad and not skip_bad_runs):
        raise CampaignError(path, reading.all_faults)
    return dataclasses.replace(campaign, skipped=bad, source=_source(Path(path)))


def _source(folder: Path) -> str:
    """Hash of a campaign's files, the pictures and videos beside them left out."""
    files = [folder / CAMPAIGN_FILE]
    names = (RUN_FILE, DRIVE_FILE, CAMERA_FILE, ACCELEROMETER_FILE)
    files += [run / name for run in _run_folders(folder) for name in names]
    return hash_of([file for file in files if file.is_file()], folder)


def survey(path: str | Path, *, absent: Sequence[str] = ()) -> Reading:
    """Everything that can be read of a campaign, and everything that is wrong with it.

    Args:
        path: The campaign's folder.
        absent: Names of runs that it may state something of though they aren't there.

    Returns:
        The campaign as far as it is good, and all faults.
    """
    folder = Path(path)
    try:
        folders = _run_folders(folder)
    except OSError:
        return Reading((_no_folder(folder),), None, ())
    if elsewhere := _elsewhere(folder):
        return Reading(elsewhere, None, ())
    document, faults = _rig_document(folder)
    # Counts are the campaign's to state. Where its file is at fault, any number lets the
    # runs be checked for other faults without blaming them for this one.
    counts = 1.0 if document is None else document.counts_per_rev
    runs = tuple(_read_run(each, counts_per_rev=counts) for each in folders)
    if not runs:
        faults = (*faults, _no_runs(folder))
    elif document is not None:
        names = [*(reading.name for reading in runs), *absent]
        faults = (*faults, *_strangers(document, folder, names))
    good = tuple(reading.run for reading in runs if reading.run is not None)
    campaign = None if document is None else campaign_of(document, folder, good)
    return Reading(faults, campaign, runs)


def _strangers(
    document: CampaignDocument, folder: Path, names: Sequence[str]
) -> Iterator[Fault]:
    """Faults of runs that `campaign.toml` states something of, and that aren't there."""
    text, _ = read_text(folder / CAMPAIGN_FILE, most=DOCUMENT)
    for name in document.sensors.runs:
        if name not in names:
            near = difflib.get_close_matches(name[:80], names, n=1, cutoff=0.0)
            path = ["sensors", "runs", name]
            yield Fault(
                what="a run that isn't there",
                file=CAMPAIGN_FILE,
                row=row_of(text, path),
                key=".".join(path[:2]),
                got=represented(name),
                expected="the name of a run's folder",
                remedy=f'The nearest is "{near[0]}"; delete the table if that isn\'t meant.',
            )


def _run_folders(folder: Path) -> list[Path]:
    """Folders of runs; a link that leads nowhere was one."""
    return sorted(
        each
        for each in folder.iterdir()
        if not each.name.startswith(".")
        and (each.is_dir() or (each.is_symlink() and not each.exists()))
    )


def _no_folder(folder: Path) -> Fault:
    if folder.is_dir():
        return Fault(
            what="the campaign can't be read",
            file=str(folder),
            got="a folder that can't be opened",
            expected="a folder that can",
            remedy="Check its permissions.",
        )
    there = folder.exists()
    return Fault(
        what="the campaign isn't a folder" if there else "the campaign doesn't exist",
        file=str(folder),
        got="a file" if there else "no such folder",
        expected=f"a folder with {CAMPAIGN_FILE} and one folder for each run",
        remedy=_meant(folder)
        or ("Name the campaign's folder." if there else "Check the path."),
    )


def _meant(path: Path) -> str:
    """Which campaign was likely meant, in words; empty where none is near."""
    above = next((each for each in path.resolve().parents[:2] if _is_campaign(each)), None)
    if above is not None:
        return f"It is inside a campaign: name that, {above}."
    inside = sorted(filter(_is_campaign, path.iterdir())) if path.is_dir() else []
    if inside:
        names = ", ".join(str(each) for each in inside[:5])
        return f"There are campaigns in it: name one, {names}."
    return ""


def _is_campaign(folder: Path) -> bool:
    return (folder / CAMPAIGN_FILE).is_file()


def _elsewhere(folder: Path) -> tuple[Fault, ...]:
    """The one fault of a folder that isn't the campaign, where one is near."""
    if _is_campaign(folder) or not (meant := _meant(folder)):
        return ()
    fault = Fault(
        what="this folder isn't the campaign",
        file=str(folder),
        got=f"no {CAMPAIGN_FILE} in it",
        expected=f"a folder with {CAMPAIGN_FILE} and one folder for each run",
        remedy=meant,
    )
    return (fault,)


def _no_runs(folder: Path) -> Fault:
    return Fault(
        what="the campaign has no run",
        file=str(folder),
        got="no folder inside it",
        expected=f"one folder for each run, with {RUN_FILE} and {DRIVE_FILE}",
        remedy="Copy the runs there, or name the folder that they are in.",
    )


def read_rig(folder: Path) -> tuple[Campaign | None, tuple[Fault, ...]]:
    """What a campaign's folder states of its rig.

    Args:
        folder: The folder.

    Returns:
        The campaign without runs, None if `campaign.toml` is at fault; and the faults.
    """
    document, faults = _rig_document(folder)
    return (None if document is None else campaign_of(document, folder, ())), faults


def _rig_document(folder: Path) -> tuple[CampaignDocument | None, tuple[Fault, ...]]:
    """What stands in a folder's `campaign.toml`."""
    path = folder / CAMPAIGN_FILE
    faults = tuple(linked(path, folder, CAMPAIGN_FILE))
    if faults:
        return None, faults
    return read_model(path, CampaignDocument, file=CAMPAIGN_FILE)


def campaign_of(document: CampaignDocument, folder: Path, runs: tuple[Run, ...]) -> Campaign:
    """A campaign of what its document states, and of its runs.

    Args:
        document: What stands in `campaign.toml`.
        folder: The campaign's folder, whose name it has if it isn't stated.
        runs: The runs.

    Returns:
        The campaign.
    """
    sensors = default_sensors(document.counts_per_rev)
    stated = document.sensors.model_dump(exclude_none=True, exclude={"runs"})
    return Campaign(
        name=document.name or folder.resolve().name,
        counts_per_rev=document.counts_per_rev,
        robot=document.robot.model_dump(exclude_none=True),
        sensors=dataclasses.replace(sensors, **stated),
        runs=with_camera_sigma(document, runs),
    )


def with_camera_sigma(document: CampaignDocument, runs: Iterable[Run]) -> tuple[Run, ...]:
    """Runs with the standard deviations of their cameras, where these are stated.

    Args:
        document: What stands in `campaign.toml`.
        runs: The runs.

    Returns:
        The runs.
    """
    own = {
        name: table.model_dump(exclude_none=True)
        for name, table in document.sensors.runs.items()
    }
    return tuple(
        dataclasses.replace(run, camera_sigma=own[run.name]) if run.name in own else run
        for run in runs
    )


def _read_run(folder: Path, *, counts_per_rev: float | None) -> RunReading:
    links = tuple(foreign(folder, _FILES))
    if links:
        return RunReading(folder.name, None, links)
    document, faults = read_model(
        folder / RUN_FILE, RunDocument, file=f"{folder.name}/{RUN_FILE}"
    )
    drive, drive_faults = read_drive(folder, counts_per_rev=counts_per_rev)
    camera, camera_faults = read_camera(folder)
    accelerometer, accelerometer_faults = read_accelerometer(folder)
    faults = (*faults, *drive_faults, *camera_faults, *accelerometer_faults)
    if document is not None:
        faults = (*faults, *_knock_faults(document, drive, folder))
    if faults or document is None or drive is None:
        return RunReading(folder.name, None, faults)
    initial, knock = document.initial, document.knock
    run = Run(
        name=folder.name,
        kind=document.kind,
        pretension=document.pretension,
        pretension_label=format_quantity(document.pretension, "N"),
        notes=document.notes,
        initial=None if initial is None else Initial(**dict(initial)),
        knock=None if knock is None else Knock(**dict(knock)),
        clock_offset=document.camera.clock_offset,
        drive=drive,
        camera=camera,
        accelerometer=accelerometer,
    )
    return RunReading(folder.name, run, ())


def _instant(time: float) -> str:
    """A time that can be told from its neighbours, however large."""
    return f"{time:.3f} s" if abs(time) >= EPOCH else f"{time:g} s"


def _or_shift(drive: DriveStream) -> str:
    if drive.time[0] < EPOCH:
        return ""
    return (
        ", which counts from 1970; or take its first time off every time in the run's files, "
        "so that they count from 0"
    )


def _knock_faults(
    document: RunDocument, drive: DriveStream | None, folder: Path
) -> tuple[Fault, ...]:
    knock = document.knock
    if knock is None:
        return ()
    if document.kind != "pseudo_impulse":
        fault = Fault(
            what="a knock on a run that has none",
            file=f"{folder.name}/{RUN_FILE}",
            key="knock",
            got=f'kind = "{document.kind}"',
            expected='kind = "pseudo_impulse"',
            remedy="Correct the kind, or delete the table [knock].",
        )
    elif drive is not None and not drive.time[0] <= knock.start < drive.time[-1]:
        fault = Fault(
            what="the knock isn't within the run",
            file=f"{folder.name}/{RUN_FILE}",
            key="knock.start",
            got=format_quantity(knock.start, "s"),
            expected=f"{_instant(drive.time[0])} to {_instant(drive.time[-1])} on the drive's "
            "clock",
            remedy=f"Give the moment on the clock of {DRIVE_FILE}{_or_shift(drive)}.",
        )
    else:
        return ()
    text, _ = read_text(folder / RUN_FILE, most=DOCUMENT)
    return (dataclasses.replace(fault, row=row_of(text, fault.key.split("."))),)
