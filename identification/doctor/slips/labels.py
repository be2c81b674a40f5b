"""Runs whose label is wrong, where that makes the drives' relations look broken."""

import dataclasses

from identification.doctor.case import Case, Record
from identification.doctor.samples.encoders import slow_jumps
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


def _bare(case: Case) -> Undone | None:
    """Steps without a camera: the robot's have one, the bare drives' have none."""
    steps = [record for record in case.records if record.kind == "torque_step"]
    blind = [record for record in steps if not record.filmed]
    if not blind:
        return None
    bare = [dataclasses.replace(record, kind="motor_step") for record in blind]
    return Undone(case.updated(bare), {"do": "set kind", "kind": "motor_step"})


def _start(case: Case) -> Undone | None:
    """[initial] is the operator's note; the camera saw the run begin elsewhere."""
    if all(record.initial is None for record in case.records):
        return None
    forgotten = case.map(lambda record: dataclasses.replace(record, initial=None))
    return Undone(forgotten, {"do": "leave [initial] out"})


def _jumps(case: Case) -> Undone | None:
    """Jumps of encoders in slow logs, which leave the camera behind."""
    mended = [slow_jumps(record, case.rig) for record in case.records]
    if not any(found for _, found in mended):
        return None
    return Undone(case.updated(record for record, _ in mended), {"do": "take the jump out"})


KINDS: tuple[Slip, ...] = (
    Slip("label.kind", "it is a knock", _knock),
    Slip("label.kind", "it is a bare drive's step", _bare),
    Slip("jump.alpha", "in a slow log", _jumps),
)
"""Kinds and jumps that the relations stumble over."""

STARTS: tuple[Slip, ...] = (Slip("label.initial", "the operator's note", _start),)
"""Notes that nothing but the camera's start contradicts."""
