"""Encoders that wrap, and encoders that lose counts.

A step between two samples is judged against its neighbours: the motion that they show is
taken off, and what is left is compared with what the encoder's steps usually leave, with
the encoder's resolution, and with the periods at which counters wrap. A robot that stops or
starts between two samples stands out on one side only, a jump on both.
"""

import dataclasses
import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64

from identification.doctor.case import Record, Rig
from identification.doctor.findings import Finding
from identification.doctor.words import finding

FEWEST_STEPS = 20
"""Fewer steps than this have no neighbours to speak of."""

LEAST_COUNTS = 12
"""A jump is at least this many counts: good logs leave 2.5 at most."""

STRONGEST = 8
"""Steps of the strongest acceleration that a jump is at least."""

DRIVEN = 3
"""Steps of a bare drive's strongest acceleration that one above both its neighbours is."""

SLOW = 0.0045
"""Sample period [s] above which a step's neighbours tell its motion only coarsely: 250 Hz is
on this side of it, however its time stamps round."""

FASTEST = 2e-5
"""Sample period [s] below which the time is in another unit, and speeds say nothing."""


class _Steps(NamedTuple):
    """Steps of an encoder and what its neighbours expect of them."""

    step: Float64[np.ndarray, " steps"]
    near: Float64[np.ndarray, " steps"]
    """Median of the three steps before and the three after."""
    lone: Float64[np.ndarray, " steps"]
    """Distance from the nearer of the medians before and after."""

    @property
    def out(self) -> Float64[np.ndarray, " steps"]:
        return self.step - self.near


def encoders(record: Record, rig: Rig) -> tuple[Record, tuple[Finding, ...]]:
    """Wraps and jumps of both encoders; they are taken out.

    Args:
        record: The run.
        rig: What is known of the rig.

    Returns:
        The run with angles that go on, and what was found.
    """
    found = []
    for encoder in (0, 1):
        record, finding_ = _encoder(record, rig, encoder)
        found += finding_
    return record, tuple(found)


def slow_jumps(record: Record, rig: Rig) -> tuple[Record, tuple[Finding, ...]]:
    """Jumps in a slow log that are more than its drives can do, once units are right.

    At 200 Hz a step's neighbours three before and after have seen other speeds. The next
    ones haven't: a step that is above or below both by more than the strongest command
    accelerates a bare drive is no motion.

    Args:
        record: The run, its units and clocks put right.
        rig: What is known of the rig.

    Returns:
        The run with angles that go on, and what was found.
    """
    found: list[Finding] = []
    step = np.diff(record.angle, axis=0)
    if record.period <= SLOW or len(step) < FEWEST_STEPS:
        return record, ()
    limit = max(LEAST_COUNTS * rig.count, DRIVEN * _strongest(record, rig))
    wide = np.diff(record.time) > 1.6 * record.period
    for encoder in (0, 1):
        before, after = np.diff(step[:, encoder])[:-1], -np.diff(step[:, encoder])[1:]
        sharp = np.minimum(np.abs(before), np.abs(after)) * (before * after > 0)
        rows = np.flatnonzero((sharp > limit) & ~wide[1:-1]) + 1
        if rows.size:
            record, told = _closed(record, encoder, _compared(step[:, encoder]), rows)
            found += told
    return record, tuple(found)


def _strongest(record: Record, rig: Rig) -> float:
    """What the strongest command changes a bare drive's step by [rad]."""
    return rig.voltage_limit * rig.torque_per_volt / rig.inertia * record.period**2


def wrap_periods(rig: Rig) -> dict[str, float]:
    """The periods at which angles wrap [rad], by what they are.

    Args:
        rig: What is known of the rig.

    Returns:
        The periods; 360 is a turn in degrees that are labelled rad.
    """
    return {
        "one turn": 2 * math.pi,
        "360": 360.0,
        "2^16 counts": 2**16 * rig.count,
        "2^15 counts": 2**15 * rig.count,
    }


def _short_counters(rig: Rig, span: float) -> dict[str, float]:
    """Periods of shorter counters [rad], which must hold all that the encoder shows."""
    periods = {f"2^{bits} counts": 2**bits * rig.count for bits in (14, 13, 12)}
    return {name: period for name, period in periods.items() if span < 1.01 * period}


def _encoder(record: Record, rig: Rig, encoder: int) -> tuple[Record, list[Finding]]:
    step = np.diff(record.angle[:, encoder])
    if len(step) < FEWEST_STEPS or not np.any(step):
        return record, []
    steps = _compared(step)
    rows = np.flatnonzero(_standing_out(steps, record, rig))
    if not rows.size:
        return record, []
    size = np.abs(steps.out[rows])
    typical = float(np.median(size))
    span = float(np.ptp(record.angle[:, encoder]))
    for name, period in (wrap_periods(rig) | _short_counters(rig, span)).items():
        turns = np.abs(size / period - 1) < 0.03
        if turns.any():
            record, told = _unwrapped(record, encoder, steps, rows[turns], period, [name])
            return (record, told) if turns.all() else _rest(record, rig, encoder, told)
    if len(rows) >= 3 and float(np.mean(np.abs(size / typical - 1) < 0.05)) > 0.7:
        return _unwrapped(record, encoder, steps, rows, typical, [])
    return _closed(record, encoder, steps, rows)


def _rest(
    record: Record, rig: Rig, encoder: int, told: list[Finding]
) -> tuple[Record, list[Finding]]:
    """Lost counts beside wraps, which are taken out already."""
    steps = _compared(np.diff(record.angle[:, encoder]))
    rows = np.flatnonzero(_standing_out(steps, record, rig))
    if not rows.size:
        return record, told
    record, more = _closed(record, encoder, steps, rows)
    return record, [*told, *more]


def _compared(step: Float64[np.ndarray, " steps"]) -> _Steps:
    padded = np.pad(step, 3, mode="edge")
    side = np.stack([padded[shift : shift + len(step)] for shift in (0, 1, 2, 4, 5, 6)])
    before, after = np.median(side[:3], axis=0), np.median(side[3:], axis=0)
    lone = np.minimum(np.abs(step - before), np.abs(step - after))
    return _Steps(step, np.median(side, axis=0), lone)


def _standing_out(steps: _Steps, record: Record, rig: Rig) -> Bool[np.ndarray, " steps"]:
    """Steps that can't be motion."""
    count = float(np.min(np.abs(steps.step[steps.step != 0])))
    # A step differs from its neighbours by what the strongest command does in a few periods.
    strongest = _strongest(record, rig)
    least = STRONGEST * strongest
    if record.period > SLOW or record.period < FASTEST:
        # At 100 Hz and slower that is as much as the robot moves.
        least = max(DRIVEN * strongest, 2.2 * float(np.quantile(np.abs(steps.near), 0.9)))
    usual = 8 * float(np.quantile(np.abs(steps.out), 0.93))
    limit = max(usual, LEAST_COUNTS * count, least)
    turns = np.zeros(len(steps.step), dtype=bool)
    for period in wrap_periods(rig).values():
        # An encoder that dithers about its wrap jumps so often that quantiles see nothing
        # odd: whole turns are told by their size.
        whole = np.abs(np.abs(steps.out) / period - 1) < 0.2
        turns |= whole & (np.abs(steps.near) < 0.35 * period)
    wide = np.diff(record.time) > 1.6 * record.period
    jumps = (np.abs(steps.out) > limit) & (steps.lone > limit)
    return (jumps | turns) & ~wide


def _unwrapped(
    record: Record,
    encoder: int,
    steps: _Steps,
    rows: np.ndarray,
    period: float,
    names: list[str],
) -> tuple[Record, list[Finding]]:
    # A named period is exact, so that the whole step counts turns; a period that was only
    # measured counts what stands out.
    counted = steps.step if names else steps.out
    turns = np.round(counted / period) * (np.abs(counted) > 0.5 * period)
    record = _less(record, encoder, turns * period)
    column = f"alpha_{encoder + 1}"
    told = finding(
        "wrap.alpha",
        "contradiction",
        runs=[record.name],
        what=f"`{column}` jumps {len(rows)} times by {period:.5g} rad"
        + (f", {names[0]}" if names else ""),
        stream="drive",
        column=column,
        row=int(rows[0]) + 1,
        evidence={"period_rad": period, "times": len(rows)},
        mend={"do": "unwrap", "run": record.name, "column": column, "period_rad": period},
    )
    return record, [told]


def _closed(
    record: Record, encoder: int, steps: _Steps, rows: np.ndarray
) -> tuple[Record, list[Finding]]:
    jump = np.zeros(len(steps.step))
    jump[rows] = steps.out[rows]
    record = _less(record, encoder, jump)
    column, size = f"alpha_{encoder + 1}", float(jump[rows[0]])
    told = finding(
        "jump.alpha",
        "contradiction",
        runs=[record.name],
        what=f"`{column}` jumps by {size:.4g} rad at t = {record.time[rows[0] + 1]:.4g} s",
        stream="drive",
        column=column,
        row=int(rows[0]) + 1,
        evidence={"jump_rad": size, "times": len(rows)},
        mend={"do": "take the jump out", "run": record.name, "column": column},
    )
    return record, [told]


def _less(record: Record, encoder: int, jumps: Float64[np.ndarray, " steps"]) -> Record:
    angle = record.angle.copy()
    angle[1:, encoder] -= np.cumsum(jumps)
    return dataclasses.replace(record, angle=angle)
