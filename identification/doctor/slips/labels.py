"""Runs whose label is wrong, where that makes the drives' relations look broken."""

import dataclasses

from identification.doctor.case import Case, Record
from identification.doctor.samples.motion import knocked
from identification.doctor.slips.edits import Undone
from identification.doctor.slips.slip import Slip


def _knock(case: Case) -> Undone | None:
    """Runs in which the drives were pushed tell nothing of what a command does."""

    def mislabelled(record: Record) -> bool:
        driven = record.kind in ("torque_step", "manoeuvre", "breakaway")
        return driven and record.filmed and knocked(record, case.rig)

    runs = [record for record in case.records if mislabelled(record)]
    if not runs:
        return None
    knocks = [dataclasses.replace(record, kind="pseudo_impulse") for record in runs]
    step = {"do": "set kind", "kind": "pseudo_impulse"}
    return Undone(case.updated(knocks), step)


def _start(case: Case) -> Undone | None:
    """[initial] is the operator's note; the camera saw the run begin elsewhere."""
    if all(record.initial is None for record in case.records):
        return None
    forgotten = case.map(lambda record: dataclasses.replace(record, initial=None))
    return Undone(forgotten, {"do": "leave [initial] out"})


KINDS: tuple[Slip, ...] = (Slip("label.kind", "it is a knock", _knock),)
"""Kinds that a drive's relations stumble over."""

STARTS: tuple[Slip, ...] = (Slip("label.initial", "the operator's note", _start),)
"""Notes that nothing but the camera's start contradicts."""
