"""The doctor's examination: a campaign's findings, and the campaign with them put right."""

import dataclasses
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from identification.campaign.types import Campaign
from identification.doctor.case import Case, Record, Rig, case_of
from identification.doctor.findings import Finding, merged
from identification.doctor.samples import (
    clocks,
    duplicates,
    encoders,
    excitation,
    frames,
    kinds,
    knocks,
    slow_jumps,
    starts,
    stuck,
    swings,
)
from identification.doctor.slips import conclusion

Look = Callable[[Record, Rig], tuple[Record, tuple[Finding, ...]]]
"""What looks at one run, puts right what it finds, and tells it."""

FIRST_LOOKS: tuple[Look, ...] = (clocks, encoders, stuck, frames, starts)
"""What is looked at before one sensor is held against another."""

LAST_LOOKS: tuple[Look, ...] = (slow_jumps, swings, knocks)
"""What needs clocks and scales that are right."""


class Diagnosis(NamedTuple):
    """What the doctor found, and the campaign as it should be."""

    findings: tuple[Finding, ...]
    """The findings, the gravest first."""
    case: Case
    """The campaign with everything put right that can be."""


def examine(campaign: Campaign) -> tuple[Finding, ...]:
    """What the sensors of a campaign say of each other, before anything is fitted.

    Args:
        campaign: The campaign.

    Returns:
        Contradictions, each once for the campaign with what explains it, and notes.
    """
    return diagnosis(campaign).findings


def diagnosis(campaign: Campaign) -> Diagnosis:
    """The findings, and the campaign with them put right in memory.

    Args:
        campaign: The campaign.

    Returns:
        Both.
    """
    with np.errstate(all="ignore"):  # numbers that can't be make others, which no rule fits
        return _diagnosis(campaign)


def _diagnosis(campaign: Campaign) -> Diagnosis:
    case, findings = duplicates(case_of(campaign))
    # Commands in another unit would all be strong ones: they are taken by their largest.
    largest = max(float(abs(record.voltage).max()) for record in case.records)
    strong = max(largest, case.rig.voltage_limit)
    stated, rig = case.rig, dataclasses.replace(case.rig, voltage_limit=strong)
    case, local = _looked_at(dataclasses.replace(case, rig=rig), FIRST_LOOKS)
    case = dataclasses.replace(case, rig=stated)
    case, global_ = conclusion(case)
    labels = (*kinds(case), *excitation(case))
    case, last = _looked_at(case, LAST_LOOKS)
    found = merged((*findings, *local, *global_, *labels, *last))
    return Diagnosis(found, case)


def _looked_at(case: Case, looks: tuple[Look, ...]) -> tuple[Case, list[Finding]]:
    found: list[Finding] = []

    def looked_at(record: Record) -> Record:
        for look in looks:
            record, findings = look(record, case.rig)
            found.extend(findings)
        return record

    return case.map(looked_at), found
