"""The log doctor: everything that is wrong with a campaign, and what is worth knowing."""

import dataclasses
from collections.abc import Iterable, Iterator
from pathlib import Path

from identification.campaign.faults import Fault
from identification.campaign.notes.camera import CAMERA_OBSERVATIONS
from identification.campaign.notes.drive import DRIVE_OBSERVATIONS
from identification.campaign.notes.note import Note
from identification.campaign.read import RunReading, survey
from identification.campaign.streams import ACCELEROMETER_FILE, CAMERA_FILE, DRIVE_FILE
from identification.campaign.types import Campaign, Run
from scdpr_jax.robot.stated.units import si


@dataclasses.dataclass(frozen=True, kw_only=True)
class RunSummary:
    """One run in a line of a table."""

    name: str
    """Name of its folder."""
    kind: str | None = None
    """Its kind, None if the run has faults."""
    pretension: float | None = dataclasses.field(default=None, metadata=si("N", "T"))
    """Nominal setting of the cable loop [N], None if the run has faults."""
    duration: float | None = dataclasses.field(default=None, metadata=si("s", "t"))
    """From the drive's first to its last sample [s], None if the run has faults."""
    rows: int | None = None
    """Samples of the drive, None if the run has faults."""
    camera_rows: int | None = None
    """Frames of the camera, 0 without one, None if the run has faults."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Check:
    """What is wrong with a campaign and what is worth knowing of it."""

    path: Path
    """The campaign's folder."""
    faults: tuple[Fault, ...]
    """What must be mended before the campaign can be read."""
    notes: tuple[Note, ...]
    """What is worth knowing of the runs that can be read."""
    runs: tuple[RunSummary, ...]
    """Every run."""
    campaign: Campaign | None = None
    """The campaign with the good runs, None if there is none."""

    @property
    def passed(self) -> bool:
        """Whether the campaign can be read."""
        return not self.faults


def check_campaign(path: str | Path) -> Check:
    """All faults of a campaign, and what is worth knowing of it.

    Args:
        path: The campaign's folder.

    Returns:
        What was found; content of whatever kind is never an error here.
    """
    reading = survey(path)
    campaign = reading.campaign
    notes = () if campaign is None else campaign_notes(campaign)
    return Check(
        path=Path(path),
        faults=reading.all_faults,
        notes=notes,
        runs=tuple(_summary(run) for run in reading.runs),
        campaign=campaign if campaign is not None and campaign.runs else None,
    )


def campaign_notes(campaign: Campaign) -> tuple[Note, ...]:
    """What is worth knowing of a campaign's runs.

    Args:
        campaign: The campaign.

    Returns:
        The notes, run by run; what is the same in several files is told once.
    """
    files: dict[Note, list[str]] = {}
    for run in campaign.runs:
        for file, note in _run_notes(run, campaign):
            files.setdefault(note, []).append(f"{run.name}/{file}".rstrip("/"))
    return tuple(
        dataclasses.replace(note, file=_together(names)) for note, names in files.items()
    )


def _run_notes(run: Run, campaign: Campaign) -> Iterator[tuple[str, Note]]:
    """A run's notes with the files that they are about."""
    streams = (
        (DRIVE_FILE, run.drive),
        (CAMERA_FILE, run.camera),
        (ACCELEROMETER_FILE, run.accelerometer),
    )
    for file, stream in streams:
        if stream is not None and stream.extra:
            yield file, _extra_columns(stream.extra)
    of_camera = () if run.camera is None else CAMERA_OBSERVATIONS
    for file, observe in (*DRIVE_OBSERVATIONS, *of_camera):
        for note in observe(run, campaign):
            yield file, note


def _extra_columns(headers: Iterable[str]) -> Note:
    return Note(
        what=f"columns that are kept and ignored: {', '.join(headers)}",
        cause="The format has no column of these names.",
        remedy="Nothing to do, unless one of them is a misspelt column of the format.",
    )


def _together(files: list[str]) -> str:
    return files[0] if len(files) == 1 else f"{files[0]} and {len(files) - 1} more"


def _summary(reading: RunReading) -> RunSummary:
    run = reading.run
    if run is None:
        return RunSummary(name=reading.name)
    return RunSummary(
        name=run.name,
        kind=run.kind,
        pretension=run.pretension,
        duration=float(run.drive.time[-1] - run.drive.time[0]),
        rows=len(run.drive.time),
        camera_rows=0 if run.camera is None else len(run.camera.time),
    )
