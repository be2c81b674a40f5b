"""What the doctor has to say: findings, their order, and their file."""

import dataclasses
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from identification.campaign.faults import Fault
from scdpr_jax.numerics.files import write_whole
from scdpr_jax.numerics.files.harmless import printable

Severity = Literal["fault", "contradiction", "note"]
"""How much a finding matters: it can't be read; it can't be; it is worth knowing."""

Stream = Literal["drive", "camera"]
"""One of a run's two streams."""

SEVERITIES: tuple[Severity, ...] = ("fault", "contradiction", "note")
"""The severities, the gravest first."""

NOT_INCREASING = "time doesn't increase"
"""The reader's words for a clock that was set back."""

STREAMS: Mapping[str, Stream] = {"drive.csv": "drive", "camera.csv": "camera"}
"""The stream of a file."""

FORMAT = 1
"""Version of the file of findings."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Finding:
    """One thing that the doctor has found in a campaign."""

    id: str
    """Its name in the list of identifiers: "sign.y_e"."""
    severity: Severity
    """How much it matters."""
    runs: tuple[str, ...]
    """Names of the runs that show it."""
    stream: Literal["drive", "camera"] | None = None
    """The stream in which it is, None if it is in none or in both."""
    column: str | None = None
    """The column, None if it is none or several."""
    row: int | None = None
    """Line of the first run's file, as an editor counts it."""
    evidence: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    """The figures that show it [SI]."""
    what: str
    """What was seen."""
    cause: str
    """What explains it."""
    remedy: str
    """How to put it right."""
    alternatives: tuple[str, ...] = ()
    """Other identifiers that explain it nearly as well, the likeliest first."""
    mend: Mapping[str, Any] | None = None
    """What `--mend` does about it, None if it can't."""

    def __str__(self) -> str:
        text = f"{self.id}, {_few(self.runs)}: {self.what}. {self.cause} {self.remedy}"
        if self.alternatives:
            text += f" It could also be {' or '.join(self.alternatives)}."
        return printable(text)


def _few(names: tuple[str, ...]) -> str:
    if len(names) <= 3:
        return ", ".join(names) or "the campaign"
    return f"{names[0]} and {len(names) - 1} more runs"


def from_fault(fault: Fault) -> Finding:
    """What can't be read, as a finding.

    Args:
        fault: The fault.

    Returns:
        The finding.
    """
    run, _, file = fault.file.partition("/")
    backwards = fault.what == NOT_INCREASING
    return Finding(
        id="time.jump" if backwards else "file",
        severity="fault",
        runs=(run,) if file else (),
        stream=STREAMS.get(file),
        column=fault.column.split(" [")[0] or None,
        row=fault.row,
        evidence={"got": fault.got, "expected": fault.expected},
        what=f"{fault.what}, got {fault.got}" if fault.got else fault.what,
        cause="The clock was set back, or rows are repeated." if backwards else "",
        remedy=fault.remedy,
    )


def merged(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings of one kind in several runs told once, the gravest first.

    Args:
        findings: Findings run by run; the first of a kind lends its figures.

    Returns:
        One finding for each identifier and severity, in the order of their severities,
        and otherwise as they came.
    """
    together: dict[tuple[str, str], Finding] = {}
    for finding in findings:
        key = (finding.id, finding.severity)
        first = together.setdefault(key, finding)
        if first is not finding:
            together[key] = _joined(first, finding)
    return tuple(sorted(together.values(), key=lambda each: SEVERITIES.index(each.severity)))


def _joined(first: Finding, more: Finding) -> Finding:
    runs = tuple(dict.fromkeys((*first.runs, *more.runs)))
    column = first.column if first.column == more.column else None
    return dataclasses.replace(
        first, runs=runs, column=column, mend=_joined_mend(first.mend, more.mend)
    )


def _joined_mend(
    first: Mapping[str, Any] | None, more: Mapping[str, Any] | None
) -> Mapping[str, Any] | None:
    if first is None or more is None:
        return first if more is None else more
    steps = [*first["steps"], *(step for step in more["steps"] if step not in first["steps"])]
    return {"steps": steps}


def findings_document(findings: Iterable[Finding]) -> dict[str, Any]:
    """The findings as the file has them.

    Args:
        findings: The findings.

    Returns:
        What JSON can write: lists, numbers, texts, None for what isn't finite.
    """
    return {"format": FORMAT, "findings": [_plain(_entry(each)) for each in findings]}


def write_findings(findings: Iterable[Finding], path: str | Path) -> None:
    """Write the findings as JSON.

    Args:
        findings: The findings.
        path: The file, replaced if it exists; written whole or not at all.
    """
    text = json.dumps(findings_document(findings), indent=1, ensure_ascii=False)
    write_whole(Path(path), text + "\n")


def _entry(finding: Finding) -> dict[str, Any]:
    return {field.name: getattr(finding, field.name) for field in dataclasses.fields(finding)}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float):
        # Four digits more than any figure here is worth, and no infinity: JSON has none.
        return float(f"{value:.9g}") if np.isfinite(value) else None
    return value
