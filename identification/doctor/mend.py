"""A campaign put right: what the doctor undid in memory, as runs again."""

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from identification.campaign.types import (
    CameraStream,
    Campaign,
    Run,
    default_sensors,
    encoder_resolution,
)
from identification.campaign.write import write_campaign
from identification.doctor.case import Record
from identification.doctor.examine import Diagnosis, diagnosis
from identification.doctor.findings import Finding


def mend(campaign: Campaign, path: str | Path) -> tuple[Finding, ...]:
    """Write a copy of a campaign in which everything is put right that can be.

    Args:
        campaign: The campaign; its files stay as they are.
        path: The copy's folder; must not exist, or be empty.

    Returns:
        What was put right.

    Raises:
        FileExistsError: If there is something at the path already.
    """
    found = diagnosis(campaign)
    write_campaign(mended(campaign, found), path)
    return tuple(finding for finding in found.findings if finding.mend is not None)


def mended(campaign: Campaign, found: Diagnosis) -> Campaign:
    """The campaign as the doctor put it right.

    Args:
        campaign: The campaign.
        found: Its diagnosis.

    Returns:
        The campaign, with a line in the notes of every run that was touched.
    """
    rig = found.case.rig
    counts, sensors, robot = campaign.counts_per_rev, campaign.sensors, dict(campaign.robot)
    if counts is not None and rig.count != encoder_resolution(counts):
        new = 2 * np.pi / rig.count
        new = float(round(new)) if abs(new - round(new)) < 1e-3 * new else float(new)
        if sensors.encoder_sigma == default_sensors(counts).encoder_sigma:
            sigma = default_sensors(new).encoder_sigma
            sensors = dataclasses.replace(sensors, encoder_sigma=sigma)
        counts = new
    if any(_sets_radius(finding) for finding in found.findings):
        robot["effective_radius"] = rig.radius
    runs = tuple(
        _run(record, found.findings)
        for record in found.case.records
        if not _is_left_out(record, found.findings)
    )
    return dataclasses.replace(
        campaign, runs=runs, counts_per_rev=counts, sensors=sensors, robot=robot
    )


def _steps(finding: Finding, run: str) -> list[dict]:
    """What is done to a run."""
    steps = [] if finding.mend is None else finding.mend["steps"]
    return [step for step in steps if run in step.get("runs", (step.get("run"),))]


def _is_left_out(record: Record, findings: Sequence[Finding]) -> bool:
    steps = (step for finding in findings for step in _steps(finding, record.name))
    return any(step["do"] == "leave the run out" for step in steps)


def _sets_radius(finding: Finding) -> bool:
    steps = [] if finding.mend is None else finding.mend["steps"]
    return any(step["do"] == "set effective_radius" for step in steps)


def _run(record: Record, findings: Sequence[Finding]) -> Run:
    touching = [finding for finding in findings if _steps(finding, record.name)]
    if not touching:
        return record.run
    run = record.run
    drive = dataclasses.replace(
        run.drive,
        time=record.time,
        voltage=record.voltage,
        angle=record.angle,
        current=_current(record, touching),
    )
    camera, offset = _camera(record, touching)
    return dataclasses.replace(
        run,
        kind=record.kind,
        drive=drive,
        camera=camera,
        initial=record.initial,
        knock=record.knock,
        clock_offset=offset,
        notes="\n".join([*filter(None, [run.notes]), *map(_note, touching)]),
    )


def _camera(
    record: Record, touching: Sequence[Finding]
) -> tuple[CameraStream | None, float | None]:
    """The camera's stream and its clock's offset.

    A clock that was put right by alignment is right to some tenths of a millisecond: less
    than a fit can tell. So it is put near the drive's, and the fit is asked for the rest.
    """
    run = record.run
    if run.camera is None or record.frame_time is None:
        return run.camera, run.clock_offset
    time, offset = record.frame_time, run.clock_offset
    if offset is not None and any(each.id.startswith("clock.") for each in touching):
        time, offset = time - record.offset, None
    return dataclasses.replace(run.camera, time=time, position=record.position), offset


def _current(record: Record, touching: Sequence[Finding]) -> np.ndarray | None:
    """The motors' currents, which go with the drives and not with the encoders."""
    current = record.run.drive.current
    if current is None:
        return None
    ids = {finding.id for finding in touching}
    if "swap.motors" in ids:
        current = current[:, ::-1]
    return current * [-1.0 if f"sign.motor_{motor}" in ids else 1.0 for motor in (1, 2)]


def _note(finding: Finding) -> str:
    done = ", ".join(dict.fromkeys(step["do"] for step in finding.mend["steps"]))
    return f"Mended by scdpr check: {finding.id}, {finding.cause} Done: {done}."
