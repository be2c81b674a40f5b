"""Runs that are in the campaign twice."""

import dataclasses

import numpy as np

from identification.doctor.case import Case, Record
from identification.doctor.findings import Finding
from identification.doctor.words import finding


def duplicates(case: Case) -> tuple[Case, tuple[Finding, ...]]:
    """Runs whose content is another run's; the later one is left out.

    Args:
        case: The campaign as logged.

    Returns:
        The case without them, and what was found.
    """
    first: dict[tuple[bytes, ...], str] = {}
    kept, found = [], []
    for record in case.records:
        content = _content(record)
        # Two runs in which nothing moves are alike without being one.
        if content in first and np.ptp(record.angle) > 0:
            found.append(_finding(record, first[content]))
            continue
        first.setdefault(content, record.name)
        kept.append(record)
    return dataclasses.replace(case, records=tuple(kept)), tuple(found)


def _content(record: Record) -> tuple[bytes, ...]:
    """The drive's signals from their first sample on: a copy may have another clock."""
    return record.voltage.tobytes(), (record.angle - record.angle[0]).tobytes()


def _finding(record: Record, other: str) -> Finding:
    return finding(
        "label.duplicate",
        "contradiction",
        runs=[other, record.name],
        what=f"{record.name} is {other} once more, sample by sample",
        stream="drive",
        evidence={"samples": len(record.time)},
        mend={"do": "leave the run out", "run": record.name},
    )
