"""A campaign as a fit should see it.

A fit simulates a run from rest with the commands of its log. So a run that begins in motion
is left out, and one with a gap is taken to pieces: what was commanded in the gap isn't known,
and a piece is fitted if it begins at rest, where the camera sees it. The first piece is what
the run is up to its gap; a later one that begins in motion is left out, and so told.
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
        The campaign without bad frames, without runs that begin in motion, and with runs
        that have a gap in pieces; what is left out is in its `skipped`.

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
            left.append((run.name, (_in_motion(run, moving[run.name]),)))
            continue
        pieces, reasons = _pieces(_without_bad_frames(run, rig), rig)
        runs += pieces
        left += reasons
    if not runs:
        raise ValueError(
            f"{campaign.name}: no run is left to fit, got {len(left)} that begin in motion, "
            "expected one at least that begins at rest. Log from standstill on."
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


def _in_motion(run: Run, what: str) -> Fault:
    return Fault(
        what="the run doesn't begin at rest",
        file=f"{run.name}/{DRIVE_FILE}",
        got=what,
        expected="standstill at its first sample",
        remedy="Log from standstill on; a fit would have to guess the velocities.",
    )


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
        reason = _unfit(record_of(piece), rig, first=number == 1)
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
    if knock is not None and not drive.time[0] <= knock.start < drive.time[-1]:
        knock = None
    return dataclasses.replace(
        run,
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


def _unfit(piece: Record, rig: Rig, *, first: bool) -> str:
    """Why a piece can't be fitted; empty if it can."""
    time = piece.time
    if len(time) < 2 or time[-1] - time[0] < SHORTEST:
        return f"it is shorter than {SHORTEST:g} s"
    if np.ptp(piece.angle, axis=0).max() <= STILL * rig.count and piece.run.knock is None:
        return "nothing moves in it"
    if first:
        return ""
    rest = time <= time[0] + REST
    if np.ptp(piece.angle[rest], axis=0).max() > STILL * rig.count:
        return "it begins in motion"
    if not piece.filmed:
        return "" if piece.kind == "motor_step" else "no camera sees where it begins"
    return _unseen(piece, rig)


def _unseen(piece: Record, rig: Rig) -> str:
    """Whether the camera sees the robot at rest at the start of a piece."""
    start = piece.frame_time - piece.offset <= piece.time[0] + 2 * REST
    seen = piece.position[start][:, [0, 2, 3, 4]]
    if np.isfinite(seen).sum(axis=0).min() < 2:
        return "no camera sees where it begins"
    moved = np.nanmax(seen, axis=0) - np.nanmin(seen, axis=0)
    # The noise of a few frames spans four or five of its standard deviation.
    return "it begins in motion" if moved.max() > 8 * rig.position_sigma else ""


def _not_fitted(run: Run, piece: Run, reason: str) -> Fault:
    first, last = piece.drive.time[0], piece.drive.time[-1]
    return Fault(
        what=f"samples are missing; the piece from {first:.4g} to {last:.4g} s isn't fitted",
        file=f"{run.name}/{DRIVE_FILE}",
        got=reason,
        expected="a piece that begins at rest",
        remedy="Log from the controller's own loop, at its own rate.",
    )
