"""A proposed mapping: what it says, and as the mapping that it is."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from identification.bring.mapping.document import MappingDocument
from identification.bring.proposal.choice import Choice
from identification.bring.proposal.cuts.recordings import Recording
from identification.bring.proposal.cuts.rests import Part
from identification.bring.proposal.mends import Choices

_SI = {"voltage_": "V", "alpha_": "rad"}
"""Units that a drive's columns are looked at in where nothing tells them."""
KNOCK = "pseudo_impulse"
"""Kind of the runs with a knock."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class ProposedRun:
    """A `[[run]]`."""

    name: str
    """Its name."""
    recording: Recording
    """Its logs."""
    part: Part | None = None
    """The part of them, None for all."""
    kind: str = "free"
    """Its kind."""
    why: str = ""
    """Why that."""
    pretension: str = ""
    """The setting, where the log's name says it."""
    knock: tuple[str, str] | None = None
    """Start and duration of the knock, where it shows."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Proposal:
    """A mapping that isn't one yet: a person reads it first."""

    choices: Choices
    """Columns of each stream."""
    overrides: Mapping[Path, dict[str, Choice]]
    """Columns that are otherwise in a log of another layout."""
    runs: tuple[ProposedRun, ...] = ()
    """The runs."""
    counts_per_rev: float | None = None
    """Counts of a turn by the camera, None where angles aren't counts or nothing tells it."""
    counts_known: bool = False
    """Whether a campaign states the counts already."""
    clock_offset: tuple[str, str] = ("unknown", "nothing tells it")
    """The camera's clock, and why."""
    told: tuple[str, ...] = ()
    """What else is worth saying."""

    def document(self) -> MappingDocument:
        """The proposal as a mapping, with what is left empty filled by anything.

        Returns:
            The mapping; its paths are absolute.
        """
        content: dict[str, Any] = {"defaults": {"pretension": "1 N"}, "run": []}
        for stream, columns in self.choices.items():
            if columns:
                tables = {
                    name: _filled(name, each).table()
                    for name, each in columns.items()
                    if each.channel
                }
                content[stream] = {"columns": tables}
        for run in self.runs:
            content["run"].append(self._run(run))
        return MappingDocument.model_validate(content)

    def _run(self, run: ProposedRun) -> dict[str, Any]:
        logs = run.recording.logs
        made: dict[str, Any] = {"name": run.name, "kind": run.kind}
        for stream, paths in logs.items():
            if paths:
                made[f"{stream}_log"] = [str(path.absolute()) for path in paths]
                other = self.overrides.get(paths[0], {})
                of_stream = {
                    n: c.table() for n, c in other.items() if n in self.choices[stream]
                }
                made[f"{stream}_columns"] = of_stream
        if run.part is not None:
            made |= {"from": f"{run.part.begin!r} s", "to": f"{run.part.end!r} s"}
        if self.clock_offset[0] != "unknown":
            made["camera"] = {"clock_offset": self.clock_offset[0]}
        return made


def _filled(name: str, choice: Choice) -> Choice:
    """A choice whose unit nothing tells, in SI: enough to see when it moves."""
    if choice.unit or name == "t":
        return choice
    return dataclasses.replace(choice, unit=_SI.get(name[:-1], ""))
