"""`scdpr import LOG… --propose`: looks at logs and writes the mapping that it would use."""

import dataclasses
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from identification.bring.campaign_import import told
from identification.bring.files.channel import Log
from identification.bring.files.csv.dialect import Dialect
from identification.bring.files.open import open_logs
from identification.bring.proposal.cuts.kinds import kind_of
from identification.bring.proposal.cuts.recordings import Recording, going_on, recordings
from identification.bring.proposal.cuts.rests import parts
from identification.bring.proposal.encoders import numbers_a_radian, unit_of
from identification.bring.proposal.look.columns import StreamColumns, choices, stream_columns
from identification.bring.proposal.mends import mended
from identification.bring.proposal.proposal import KNOCK, Proposal, ProposedRun
from identification.bring.proposal.text import mapping_text
from identification.bring.runs import runs_of
from identification.campaign.extend import rig_of_folder
from identification.campaign.faults import CampaignError, Fault
from identification.campaign.types import AccelerometerStream, Campaign, Run
from identification.doctor.case import rig_of
from identification.doctor.examine import examine
from identification.doctor.findings import Finding
from scdpr_jax.numerics.files import write_whole

_SETTING = re.compile(r"(?<![\d.])(\d{2,4}(?:\.\d+)?)[ _]?N(?![a-zA-Z])")
"""A pretension in a log's name: `knock_350N_03.csv`."""
_COUNTS = 26624.0
"""Counts of a turn where neither a campaign nor the camera says any: the paper's rig's."""
_ROUNDS = 4
"""How often the doctor is asked: a sign may hide a plug. The last time nothing is changed."""


def propose_mapping(
    logs: Sequence[str | Path], path: str | Path, *, into: str | Path | None = None
) -> Proposal:
    """Write the mapping that logs seem to ask for.

    Args:
        logs: The logs.
        path: The mapping to write, replaced if it exists.
        into: A campaign's folder whose `campaign.toml` says what is known of the rig.

    Returns:
        What was proposed.

    Raises:
        CampaignError: If a log can't be read, or none is a drive's.
    """
    rig = None if into is None else rig_of_folder(into)
    opened, faults = open_logs([(Path(log), Dialect()) for log in logs])
    if faults:
        raise CampaignError(path, told(faults), what="proposal")
    with np.errstate(all="ignore"):  # numbers that can't be make others, which nothing fits
        proposal = propose(opened, rig or Campaign(name="", runs=()), path=Path(path))
    write_whole(Path(path), mapping_text(proposal, Path(path)))
    return proposal


def propose(logs: Mapping[Path, Log], rig: Campaign, *, path: Path) -> Proposal:
    """The mapping that open logs seem to ask for.

    Args:
        logs: The logs by path.
        rig: What is known of the rig; its runs don't count.
        path: Where the mapping will be, for messages.

    Returns:
        The proposal.

    Raises:
        CampaignError: If none of the logs is a drive's.
    """
    streams = stream_columns(logs)
    if "drive" not in streams:
        raise CampaignError(path, (_no_drive(logs),), what="proposal")
    drive = streams["drive"]
    others = (streams[n].logs if n in streams else () for n in ("camera", "accelerometer"))
    made, alone = recordings(drive.logs, *others, going_on(_times(drive, logs)))
    proposal = Proposal(
        choices=choices(streams),
        overrides=_overrides(streams),
        runs=tuple(_whole(made)),
        counts_known=rig.counts_per_rev is not None,
        told=tuple(f"{each.name} belongs to no drive's log: left out" for each in alone),
    )
    return _by_signals(proposal, logs, rig, streams)


def _no_drive(logs: Mapping[Path, Log]) -> Fault:
    first = next(iter(logs.values()))
    objects = [c for log in logs.values() for c in log.channels.values() if c.missing]
    if objects:
        got, _, remedy = objects[0].missing.partition("|")
        return Fault(
            what="what only MATLAB can read",
            file=str(first.path),
            got=f"{objects[0].name!r}, {got}",
            expected="arrays or structures",
            remedy=remedy,
        )
    return Fault(
        what="no log has commands and encoders",
        file=str(first.path),
        got=f"channels {', '.join(map(repr, list(first.channels)[:12]))}",
        expected="two voltages and two angles, whatever they are called",
        remedy="Name the drive's logs, too; or write the mapping by hand, see docs/import.md.",
    )


def _times(drive: StreamColumns, logs: Mapping[Path, Log]) -> dict[Path, np.ndarray]:
    """Time of the logs that state it in a column."""
    if "t" not in drive.given:
        return {}
    name = drive.given["t"].signal.channel
    return {
        path: logs[path].channels[name].values
        for path in drive.logs
        if name in logs[path].channels and logs[path].channels[name].is_number
    }


def _overrides(streams: Mapping[str, StreamColumns]) -> dict[Path, dict]:
    """Columns of logs of other layouts, as far as they differ."""
    made: dict[Path, dict] = {}
    for stream, columns in streams.items():
        main = choices({stream: columns})[stream]
        for path, given in columns.others.items():
            other = choices({stream: dataclasses.replace(columns, given=given, others={},
                             values={n: columns.values.get(n, [r.signal.values])
                                     for n, r in given.items()})})[stream]  # fmt: skip
            made.setdefault(path, {}).update(
                {n: each for n, each in other.items()
                 if each.channel and (n not in main or main[n].channel != each.channel)}
            )  # fmt: skip
    return made


def _whole(made: Sequence[Recording]) -> list[ProposedRun]:
    """Every recording as one run, until it is cut."""
    runs = []
    for number, recording in enumerate(made, start=1):
        match = _SETTING.search(recording.drive[0].name)
        setting = "" if match is None else f"{match[1]} N"
        runs.append(ProposedRun(name=f"{number:04d}", recording=recording, pretension=setting))
    return runs


def _by_signals(
    proposal: Proposal,
    logs: Mapping[Path, Log],
    rig: Campaign,
    streams: Mapping[str, StreamColumns],
) -> Proposal:
    """The proposal with what signals tell: units of angles, slips, cuts, kinds and knocks."""
    proposal = dataclasses.replace(proposal, clock_offset=("0 s", ""))
    whole, changes = proposal.runs, []
    for left in reversed(range(_ROUNDS)):
        proposal = dataclasses.replace(proposal, runs=whole)
        # Anew each time: the counts of a turn were those of the wrong carriage, perhaps.
        proposal = _encoders(proposal, logs, rig, streams)
        counts = rig.counts_per_rev or proposal.counts_per_rev or _COUNTS
        runs = _runs(proposal, logs, counts)
        if not runs:
            break
        # Kinds first: to the doctor, bare drives are a robot's that is far too light.
        proposal = _cut(proposal, runs, rig)
        campaign = dataclasses.replace(
            rig, runs=_runs(proposal, logs, counts), counts_per_rev=counts
        )
        findings = examine(campaign)
        changed, lines = mended(proposal.choices, findings)
        if not lines or not left:
            proposal = _knocks_and_clock(proposal, campaign, findings)
            break
        changes += lines
        proposal = dataclasses.replace(proposal, choices=changed)
    told_ = tuple(f"changed after looking at the signals: {line}" for line in changes)
    return dataclasses.replace(proposal, told=(*proposal.told, *told_))


def _runs(
    proposal: Proposal, logs: Mapping[Path, Log], counts: float | None
) -> tuple[Run, ...]:
    """The runs that can be made of a proposal as it stands."""
    by_path = {path.absolute(): log for path, log in logs.items()}
    document = proposal.document()
    return runs_of(document, by_path, home=Path(), file="", counts_per_rev=counts).runs


def _encoders(
    proposal: Proposal,
    logs: Mapping[Path, Log],
    rig: Campaign,
    streams: Mapping[str, StreamColumns],
) -> Proposal:
    """The unit of the encoders, or the counts of a turn, by the camera."""
    drive = dict(proposal.choices["drive"])
    names = [name for name in ("alpha_1", "alpha_2") if drive[name].channel]
    if not names:
        return proposal
    as_radians = {
        **drive, **{name: dataclasses.replace(drive[name], unit="rad") for name in names}
    }  # fmt: skip
    trial = dataclasses.replace(proposal, choices={**proposal.choices, "drive": as_radians})
    number = numbers_a_radian(_runs(trial, logs, None), rig)
    given = streams["drive"].given
    for name in names:
        if not drive[name].unit.strip(" -1"):
            unit, why = unit_of(number, whole=given[name].looks.whole)
            drive[name] = drive[name].because(f"no unit is stated; {why}", unit=unit)
    counted = any(
        drive[name].unit.lower().startswith(("count", "inc", "tick")) for name in names
    )
    counts = None if number is None or not counted else float(round(2 * np.pi * number))
    return dataclasses.replace(
        proposal, choices={**proposal.choices, "drive": drive}, counts_per_rev=counts
    )


def _cut(proposal: Proposal, runs: Sequence[Run], rig: Campaign) -> Proposal:
    """The proposal's runs cut where they rest, with their kinds."""
    by_name = {run.name: run for run in runs}
    limits = rig_of(dataclasses.replace(rig, runs=tuple(runs)))
    made: list[ProposedRun] = []
    for proposed in proposal.runs:
        run = by_name.get(proposed.name)
        pieces = [None] if run is None else parts(run)
        whole = len(pieces) < 2
        for piece in pieces:
            part = run if whole else _between(run, piece.begin, piece.end)
            named = proposed.recording.kind if whole else ""
            kind, why = ("free", "its signals can't be read yet")
            if part is not None:
                kind, why = kind_of(part, limits, named)
            name = f"{len(made) + 1:04d}-{kind.replace('_', '-')}"
            made.append(
                dataclasses.replace(
                    proposed, name=name, kind=kind, why=why, part=None if whole else piece
                )
            )
    return dataclasses.replace(proposal, runs=tuple(made))


def _between(run: Run, begin: float, end: float) -> Run:
    """A part of a run."""
    drive, camera = run.drive, run.camera
    rows = (drive.time >= begin) & (drive.time <= end)
    drive = dataclasses.replace(
        drive, time=drive.time[rows], voltage=drive.voltage[rows], angle=drive.angle[rows],
        current=None, tension=None, reference=None,
    )  # fmt: skip
    if camera is not None:
        offset = run.clock_offset or 0.0
        frames = (camera.time - offset >= begin) & (camera.time - offset <= end)
        camera = dataclasses.replace(
            camera, time=camera.time[frames], position=camera.position[frames]
        )
    accelerometer = run.accelerometer
    if accelerometer is not None:
        rows = (accelerometer.time >= begin) & (accelerometer.time <= end)
        accelerometer = AccelerometerStream(
            time=accelerometer.time[rows], along=accelerometer.along[rows]
        )
    return dataclasses.replace(run, drive=drive, camera=camera, accelerometer=accelerometer)


def _knocks_and_clock(
    proposal: Proposal, campaign: Campaign, found: Sequence[Finding]
) -> Proposal:
    """The proposal with the knocks that are seen, and what the clocks say."""
    steps = [step for each in found if each.mend is not None for step in each.mend["steps"]]
    knocks = {
        step["run"]: (step["start"], step["duration"])
        for step in steps
        if step["do"] == "write [knock]"
    }
    runs = tuple(
        dataclasses.replace(run, knock=knocks.get(run.name) if run.kind == KNOCK else None)
        for run in proposal.runs
    )
    return dataclasses.replace(
        proposal,
        runs=runs,
        clock_offset=_clock(proposal, campaign, [each.id for each in found]),
    )


def _clock(
    proposal: Proposal, campaign: Campaign, identifiers: Sequence[str]
) -> tuple[str, str]:
    """What may be said of the camera's clock, and why."""
    if any(each.startswith("clock.") for each in identifiers):
        return "unknown", "the encoders and the camera disagree by more than a clock at 0 s can"
    driven = [
        run
        for run in campaign.runs
        if run.camera is not None and np.ptp(run.drive.angle, axis=0).max() > 0.5
    ]
    if driven:
        return "0 s", f"encoders and camera move together in {len(driven)} runs"
    return "unknown", "no run with a camera moves far enough to tell"
