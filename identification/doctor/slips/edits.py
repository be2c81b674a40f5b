"""Changes to a case's signals, column by column, with what they are in words."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from identification.doctor.case import CAMERA_COLUMNS, Case, Record

POSITIONS = ("x_e", "q_3", "q_4", "y_e")
"""The camera's lengths."""

TIMES = ("drive t", "camera t")
"""The clocks of both streams."""

VOLTAGES = ("voltage_1", "voltage_2")
"""The commands."""

ANGLES = ("alpha_1", "alpha_2")
"""The encoders."""


class Undone(NamedTuple):
    """A case in which a slip is undone."""

    case: Case
    """The case."""
    step: Mapping[str, Any]
    """What was done, for `mend`."""
    factor: float | None = None
    """The factor, offset or rate that was estimated, if one was."""
    also: tuple[str, ...] = ()
    """Other slips that the same factor may hold: data can't tell two factors from one."""


def affine(case: Case, columns: Sequence[str], factor: float, shift: float = 0.0) -> Case:
    """The case with some columns scaled, and then shifted.

    Args:
        case: The campaign.
        columns: Names of the columns; `TIMES` for the clocks.
        factor: The factor.
        shift: What is added then [SI].

    Returns:
        The changed case; every other array is the one it was.
    """
    return case.map(lambda record: _affine(record, columns, factor, shift))


def _affine(record: Record, columns: Sequence[str], factor: float, shift: float) -> Record:
    def change(values: np.ndarray, names: Sequence[str]) -> np.ndarray:
        places = [place for place, name in enumerate(names) if name in columns]
        if not places:
            return values
        values = values.copy()
        values[:, places] = shift + factor * values[:, places]
        return values

    clocks = {}
    if "drive t" in columns:
        clocks["time"] = shift + factor * record.time
    if "camera t" in columns and record.filmed:
        clocks["frame_time"] = shift + factor * record.frame_time
    if clocks and not record.offset_known:
        clocks |= {"offset": 0.0, "settled": not record.filmed}
    return dataclasses.replace(
        record,
        voltage=change(record.voltage, VOLTAGES),
        angle=change(record.angle, ANGLES),
        position=change(record.position, CAMERA_COLUMNS) if record.filmed else None,
        **clocks,
    )


def scaled(case: Case, columns: Sequence[str], factor: float) -> Undone:
    """Some columns scaled.

    Args:
        case: The campaign.
        columns: Names of the columns.
        factor: The factor.

    Returns:
        The case, and what was done.
    """
    step = {"do": "scale", "columns": list(columns), "factor": factor}
    return Undone(affine(case, columns, factor), step, factor)


def mirrored(case: Case, columns: Sequence[str], size: float) -> Undone:
    """Some columns counted from the other end.

    Args:
        case: The campaign.
        columns: Names of the columns.
        size: Where the other end is [SI].

    Returns:
        The case, and what was done.
    """
    step = {"do": "count from the other end", "columns": list(columns), "from": size}
    return Undone(affine(case, columns, -1.0, size), step)


def exchanged(case: Case, pairs: Sequence[tuple[str, str]]) -> Undone:
    """Some columns exchanged.

    Args:
        case: The campaign.
        pairs: Names of the columns, two by two.

    Returns:
        The case, and what was done.
    """
    other = {a: b for pair in pairs for a, b in (pair, pair[::-1])}

    def change(values: np.ndarray, names: Sequence[str]) -> np.ndarray:
        order = [names.index(other.get(name, name)) for name in names]
        return values if order == list(range(len(names))) else values[:, order]

    def exchange(record: Record) -> Record:
        position = change(record.position, CAMERA_COLUMNS) if record.filmed else None
        clock = {}
        if position is not record.position and not record.offset_known:
            # It was estimated with the other carriage, which lags.
            clock = {"offset": 0.0, "settled": False}
        return dataclasses.replace(
            record,
            voltage=change(record.voltage, VOLTAGES),
            angle=change(record.angle, ANGLES),
            position=position,
            **clock,
        )

    return Undone(case.map(exchange), {"do": "exchange", "columns": [list(p) for p in pairs]})


def commanded(case: Case, change: Callable[[Record], np.ndarray], what: str) -> Undone:
    """The commands changed run by run.

    Args:
        case: The campaign.
        change: The new commands of a run [V].
        what: What is done, for `mend`.

    Returns:
        The case, and what was done.
    """
    new = case.map(lambda record: dataclasses.replace(record, voltage=change(record)))
    return Undone(new, {"do": what, "columns": list(VOLTAGES)})
