"""A campaign as a fit should see it.

A fit simulates a run with the commands of its log. One with a gap is taken to pieces: what was
commanded in the gap isn't known. A run, or a piece, that begins in motion is fitted with the
velocities that it begins with, if its first samples tell them: the encoders those of the
drives, the camera the rest. What can't be fitted is left out, and so told.
"""

import dataclasses
import itertools
from typing import TypeVar

import numpy as np
from jaxtyping import Bool

from identification.campaign.faults import Fault
from identification.campaign.streams import DRIVE_FILE
from identification.campaign.types import CameraStream, Campaign, DriveStream, Run
from identification.doctor.case import Record, Rig, record_of, rig_of
from identification.doctor.examine import Diagnosis
from identification.doctor.samples import frames

SHORTEST = 0.3
"""Shortest piece [s] that tells anything: a swing is as long."""

REST = 0.05
"""How long a piece must rest at its start [s]: two frames of a camera at 30 fps."""

SOON = 0.1
"""How soon after its first row the camera has to see a piece that begins in motion [s]."""

FRAMES = 12
"""Frames of each column that it takes: ten numbers of the start are estimated by them."""

STILL = 3
"""Counts within which an encoder stands still."""

Stream = TypeVar("Stream", DriveStream, CameraStream)

LeftOut = tuple[str, tuple[Fault, ...]]
"""Name of what is left out, and why."""


def fittable(campaign: Campaign, found: Diagnosis) -> Campaign:
    """The campaign without what can't be fitted, with the knocks that are seen.

    What contradicts itself stays as it is: whoever goes on with it has decided so.

    Args:
        campaign: The campaign.
        found: Its diagnosis.

    Returns:
        The campaign without bad frames, with runs that have a gap in pieces, and with those
        that begin in motion marked; what is left out is in its `skipped`.

    Raises:
        ValueError: If nothing is left.
    """
    rig = rig_of(campaign)
    knocks = {record.name: record.knock for record in found.case.records}
    sound = all(finding.severity == "note" for finding in found.findings)
    moving = {
        name: finding.what
        for finding in found.findings
        if finding.id == "start.moving"
        for name in finding.runs
    }
    runs: list[Run] = []
    left: list[LeftOut] = []
    for run in campaign.runs:
        if run.knock is None and sound:
            run = dataclasses.replace(run, knock=knocks.get(run.name))
        if run.name in moving:
            reason = _untold(run, run)
            if reason:
                fault = _in_motion(run, moving[run.name], reason)
                left.append((run.name, (fault,)))
                continue
            run = dataclasses.replace(run, in_motion=True)
        pieces, reasons = _pieces(_without_bad_frames(run, rig), rig)
        runs += pieces
        left += reasons
    if not runs:
        raise ValueError(
            f"{campaign.name}: no run is left to fit, got {len(left)} that begin in motion and "
            "don't tell how, expected one at least that begins at rest. Log from standstill on."
        )
    return dataclasses.replace(campaign, runs=tuple(runs), skipped=(*campaign.skipped, *left))


def _without_bad_frames(run: Run, rig: Rig) -> Run:
    if run.camera is None:
        return run
    record, bad = frames(record_of(run), rig)
    if not bad:
        return run
    return dataclasses.replace(
        run, camera=dataclasses.replace(run.camera, position=record.position)
    )


def _in_motion(run: Run, what: str, reason: str) -> Fault:
    return Fault(
        what="the run doesn't begin at rest",
        file=f"{run.name}/{DRIVE_FILE}",
        got=f"{what}; {reason}",
        expected="standstill at its first sample, or a camera that sees how it begins",
        remedy="Log from standstill on; a fit would have to guess the velocities.",
    )


def _untold(run: Run, piece: Run) -> str:
    """Why it can't be told how a run or a piece of it in motion begins; empty if it can."""
    if run.kind == "motor_step":
        return ""
    knock = run.knock
    first = piece.drive.time[0]
    if knock is not None and knock.start < first < knock.start + knock.duration:
        return "it begins while it is knocked"
    return "" if _seen(record_of(piece)) else "no camera sees how it begins"


def _seen(piece: Record) -> bool:
    """Whether each of the camera's columns is seen soon after the first row, and then on."""
    if not piece.filmed:
        return False
    inside = piece.frame_time - piece.offset >= piece.time[0]
    stamps, seen = piece.frame_time[inside] - piece.offset, np.isfinite(piece.position[inside])
    soon = seen[stamps <= piece.time[0] + SOON]
    return bool(np.all(soon.any(axis=0)) and np.all(seen.sum(axis=0) >= FRAMES))


def _pieces(run: Run, rig: Rig) -> tuple[list[Run], list[LeftOut]]:
    """A run parted at its gaps, and the parts that can't be fitted."""
    gaps = record_of(run).gaps
    if not gaps:
        return [run], []
    kept: list[Run] = []
    left: list[LeftOut] = []
    edges = (-np.inf, *(end for _, end in gaps), np.inf)
    for number, (begin, end) in enumerate(itertools.pairwise(edges), start=1):
        piece = _between(run, begin, end, number)
        record = record_of(piece)
        reason = _uninformative(record, rig)
        if not reason and number > 1 and not _at_rest(record, rig):
            piece, reason = dataclasses.replace(piece, in_motion=True), _untold(run, piece)
        if reason:
            left.append((piece.name, (_not_fitted(run, piece, reason),)))
        else:
            kept.append(piece)
    return kept, left


def _between(run: Run, begin: float, end: float, number: int) -> Run:
    """The samples from one instant up to another, as a run of its own."""
    inside = (run.drive.time >= begin) & (run.drive.time < end)
    drive = _rows(run.drive, inside)
    camera = run.camera
    if camera is not None:
        time = camera.time - (run.clock_offset or 0.0)
        camera = _rows(camera, (time >= drive.time[0]) & (time <= drive.time[-1]))
    knock = run.knock
    kind = run.kind
    if knock is not None and not drive.time[0] <= knock.start < drive.time[-1]:
        knock, kind = None, "free"
    return dataclasses.replace(
        run,
        kind=kind,
        name=run.name if number == 1 else f"{run.name}, piece {number}",
        drive=drive,
        camera=camera,
        initial=run.initial if number == 1 else None,
        knock=knock,
    )


def _rows(stream: Stream, rows: Bool[np.ndarray, " _"]) -> Stream:
    """Some rows of a stream, without the columns that the format doesn't know."""
    columns = {field.name: getattr(stream, field.name) for field in dataclasses.fields(stream)}
    columns = {
        name: None if column is None else column[rows]
        for name, column in columns.items()
        if name != "extra"
    }
    return dataclasses.replace(stream, **columns, extra={})


def _uninformative(piece: Record, rig: Rig) -> str:
    """Why a piece tells nothing; empty if it does."""
    time = piece.time
    if len(time) < 2 or time[-1] - time[0] < SHORTEST:
        return f"it is shorter than {SHORTEST:g} s"
    if np.ptp(piece.angle, axis=0).max() <= STILL * rig.count and piece.run.knock is None:
        return "nothing moves in it"
    return ""


def _at_rest(piece: Record, rig: Rig) -> bool:
    """Whether encoders and camera see a piece at rest at its start."""
    rest = piece.time <= piece.time[0] + REST
    if np.ptp(piece.angle[rest], axis=0).max() > STILL * rig.count:
        return False
    if not piece.filmed:
        return piece.kind == "motor_step"
    start = piece.frame_time - piece.offset <= piece.time[0] + 2 * REST
    seen = piece.position[start][:, [0, 2, 3, 4]]
    if np.isfinite(seen).sum(axis=0).min() < 2:
        return False
    moved = np.nanmax(seen, axis=0) - np.nanmin(seen, axis=0)
    # The noise of a few frames spans four or five of its standard deviation.
    return bool(moved.max() <= 8 * rig.position_sigma)


def _not_fitted(run: Run, piece: Run, reason: str) -> Fault:
    first, last = piece.drive.time[0], piece.drive.time[-1]
    return Fault(
        what=f"samples are missing; the piece from {first:.4g} to {last:.4g} s isn't fitted",
        file=f"{run.name}/{DRIVE_FILE}",
        got=reason,
        expected="a piece that begins at rest, or that the camera sees begin",
        remedy="Log from the controller's own loop, at its own rate.",
    )
