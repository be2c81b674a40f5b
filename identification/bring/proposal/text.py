"""A proposal as a TOML file that a person reads, corrects and runs."""

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from identification.bring.proposal.choice import Choice
from identification.bring.proposal.proposal import KNOCK, Proposal, ProposedRun
from identification.campaign.write import toml_text

HEAD = """\
# A mapping for `scdpr import`, proposed from names, units and signals of the logs.
# Read it, correct it, fill in what is left empty (""), then
#   scdpr import {name} --into CAMPAIGN
# docs/import.md tells what may stand here.
format = 1
"""
"""What a proposed mapping begins with."""


def mapping_text(proposal: Proposal, path: Path) -> str:
    """A proposal as the text of a mapping.

    Args:
        proposal: The proposal.
        path: Where it will be, for the paths in it.

    Returns:
        The text.
    """
    lines = [HEAD.format(name=_comment(path.name))]
    lines += [f"# {_comment(line)}" for line in proposal.told]
    lines += [*_campaign(proposal), *_defaults(proposal)]
    for run in proposal.runs:
        lines += _run(proposal, run, path)
    for stream, columns in proposal.choices.items():
        if columns:
            lines += ["", f"[{stream}.columns]"]
            lines += [line for name, each in columns.items() for line in _column(name, each)]
    return "\n".join(lines) + "\n"


def _comment(text: str) -> str:
    """A text that stays within a line of comment."""
    return "".join(mark if mark.isprintable() else "?" for mark in text)


def _campaign(proposal: Proposal) -> Iterator[str]:
    units = {proposal.choices["drive"][n].unit for n in ("alpha_1", "alpha_2")
             if n in proposal.choices["drive"]}  # fmt: skip
    if "count" not in units or proposal.counts_known:
        return
    yield "\n[campaign]"
    yield "# The encoders count; how many counts a turn of a driver pulley has, no log says."
    if proposal.counts_per_rev is not None:
        yield (
            f"# By the camera it has about {proposal.counts_per_rev:.5g}, with pulleys of the "
            "paper's 73 mm radius."
        )
    yield 'counts_per_rev = ""'


def _defaults(proposal: Proposal) -> Iterator[str]:
    yield "\n[defaults]"
    yield "# What holds for every run that doesn't say otherwise."
    if any(not run.pretension for run in proposal.runs):
        yield 'pretension = ""  # the setting of the cable loop, as "350 N": no log says it'
    if any(run.recording.camera for run in proposal.runs):
        offset, why = proposal.clock_offset
        yield "[defaults.camera]"
        yield f"clock_offset = {toml_text(offset)}  # {_comment(why)}"


def _run(proposal: Proposal, run: ProposedRun, path: Path) -> Iterator[str]:
    yield "\n[[run]]"
    yield f"name = {toml_text(run.name)}"
    yield f"kind = {toml_text(run.kind)}  # {_comment(run.why)}"
    if run.pretension:
        yield f"pretension = {toml_text(run.pretension)}  # the log's name says so"
    logs = run.recording.logs
    for stream, paths in logs.items():
        if paths:
            yield f"{stream}_log = {_paths(paths, path)}"
    if run.part is not None:
        yield f'from = "{run.part.begin:.6f} s"  # it rests here'
        yield f'to = "{run.part.end:.6f} s"'
    if run.knock is not None:
        yield "[run.knock]  # where the end-effector is seen to leave its place"
        yield f'start = "{run.knock[0]}"'
        yield f'duration = "{run.knock[1]}"'
    elif run.kind == KNOCK and run.recording.accelerometer:
        yield "# No [run.knock]: the accelerometer shows it by itself."
    elif run.kind == KNOCK:
        yield "# No [run.knock]: the logs don't show when it was; state start and duration."
    for stream, paths in logs.items():
        other = proposal.overrides.get(paths[0], {}) if paths else {}
        lines = [
            line
            for name, each in other.items()
            if name in proposal.choices[stream]
            for line in _column(name, each)
        ]
        if lines:
            yield f"[run.{stream}_columns]  # this log is written otherwise"
            yield from lines


def _paths(paths: Sequence[Path], mapping: Path) -> str:
    home = mapping.absolute().parent
    names = [toml_text(_relative(path, home)) for path in paths]
    return names[0] if len(names) == 1 else f"[{', '.join(names)}]"


def _relative(path: Path, home: Path) -> str:
    try:
        return Path(os.path.relpath(path.absolute(), home)).as_posix()
    except ValueError:  # another drive of Windows
        return path.absolute().as_posix()


def _column(name: str, choice: Choice) -> Iterator[str]:
    for reason in choice.why:
        yield f"# {name}: {_comment(reason)}"
    if choice.rate:
        yield f"{name} = {{ rate = {toml_text(choice.rate)} }}"
        return
    parts = [f"channel = {toml_text(choice.channel or '')}", f"unit = {toml_text(choice.unit)}"]
    if choice.scale != 1:
        parts.append(f"scale = {choice.scale!r}")
    if choice.sign != 1:
        parts.append("sign = -1")
    if choice.offset:
        parts.append(f"offset = {toml_text(choice.offset)}")
    if choice.wraps is not None:
        parts.append(f"wraps = {choice.wraps!r}")
    if choice.lost:
        parts.append(f"lost = [{', '.join(f'{code:g}' for code in choice.lost)}]")
    if choice.own_time is not None:
        time, unit = map(toml_text, choice.own_time)
        parts.append(f"t = {{ channel = {time}, unit = {unit} }}")
    yield f"{name} = {{ {', '.join(parts)} }}"
