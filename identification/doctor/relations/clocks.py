"""The camera's clock against the drive's: an offset by alignment, offset and rate by slopes.

The alignment must not know scales, signs or which encoder is which, or a clock that is off
and a wrong unit would explain each other. It regresses the camera on both encoders at each
shift, and takes the shift that leaves least.
"""

import dataclasses
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from identification.doctor.case import Q3, Case, Record, Y
from identification.doctor.relations.pairing import Pairing, pairings
from identification.doctor.statistics import huber, spread, travel

UNKNOWN_REACH = 0.1
"""What a clock that isn't stated may be off by [s] and be no finding."""

SURE = 3.0
"""Standard errors that a clock's error may have by chance."""

ALIKE = 6.0
"""Frames in a row whose residuals are alike: what cables and play leave isn't noise."""

CREEP = 0.02
"""Speed [m/s] above which dry friction has its sign."""


class _Film(NamedTuple):
    """A run's camera, as the alignment needs it."""

    record: Record
    time: Float64[np.ndarray, " frames"]
    signal: Float64[np.ndarray, " frames"]


def alignment(
    case: Case, records: Sequence[Record], *, reach: float, step: float, about: float = 0.0
) -> float | None:
    """Common error of the camera's clock in some runs.

    Args:
        case: The campaign.
        records: The runs.
        reach: How far to look [s].
        step: Step of the first look [s]; six halvings follow.
        about: Where to look [s].

    Returns:
        Camera time minus drive time, beyond what the runs have [s]; None if nothing moves.
    """
    films = [film for record in records if (film := _film(record, case.rig.position_sigma))]
    if not films:
        return None
    grid = about + np.arange(-reach, reach + step / 2, step)
    # From the middle, so that a tie is the smallest error.
    grid = grid[np.argsort(np.abs(grid - about), kind="stable")]
    best = float(grid[int(np.argmin([_left(films, shift) for shift in grid]))])
    for halving in step / 2.0 ** np.arange(1, 7):
        near = (best, best - halving, best + halving)
        best = near[int(np.argmin([_left(films, shift) for shift in near]))]
    return float(best)


def _film(record: Record, sigma: float) -> _Film | None:
    """The column that moves most, None if it moves hardly or the encoders don't."""
    time = record.frame_time - record.offset
    seen = np.isfinite(record.position[:, Q3] + record.position[:, Y])
    if not record.trusted.all():
        seen &= np.interp(time, record.time, record.trusted.astype(float)) > 0.99
    for begin, end in record.gaps:
        seen &= (time < begin) | (time > end)
    if seen.sum() <= 12 or not np.ptp(record.angle) > 0:
        return None
    both = record.position[seen][:, [Q3, Y]]
    column = int(np.argmax(np.std(both, axis=0)))
    if travel(both[:, column]) <= 60 * sigma:
        return None
    return _Film(record, time[seen], both[:, column])


def _left(films: Sequence[_Film], shift: float) -> float:
    """Mean share of the camera's motion that both encoders leave at a shift."""
    shares = []
    for record, frames, places in films:
        time = frames - shift
        inside = (time >= record.time[0]) & (time <= record.time[-1])
        if inside.sum() < 10:
            shares.append(1.0)
            continue
        signal = places[inside] - np.mean(places[inside])
        size = float(np.std(signal))
        if size == 0:
            shares.append(1.0)
            continue
        matrix = np.stack(
            [np.interp(time[inside], record.time, record.angle[:, k]) for k in (0, 1)], axis=1
        )
        matrix -= matrix.mean(axis=0)
        matrix /= np.std(matrix, axis=0) + 1e-12
        error = signal - matrix @ np.linalg.lstsq(matrix, signal, rcond=1e-4)[0]
        shares.append(float(np.mean(np.abs(error))) / size)
    return float(np.mean(shares))


def settled(case: Case) -> Case:
    """The case with the offsets of unstated clocks estimated, one for all of them.

    Args:
        case: The campaign.

    Returns:
        The case; itself if every clock is stated or estimated.
    """
    unsettled = [record for record in case.filmed if not record.settled]
    if not unsettled:
        return case
    shift = alignment(case, unsettled, reach=UNKNOWN_REACH, step=0.02) or 0.0
    return case.updated(
        dataclasses.replace(record, settled=True, offset=record.offset + shift)
        for record in unsettled
    )


class ClockTerms(NamedTuple):
    """Error of the camera's clock."""

    offset: float
    """At the start of the runs [s]."""
    drift: float
    """Its rate [1]."""
    scale: float
    """Camera over encoders, which the regression has to allow for."""
    offset_error: float
    """What the offset may be off by, with a chance of a few in a thousand [s]."""
    drift_error: float
    """The same of the rate [1]."""


def clock_terms(case: Case) -> ClockTerms | None:
    r"""Error of the camera's clock and its rate, by one robust regression.

    The camera is regressed on the encoders, on their speed, and on their speed times the
    time in the run: to first order the last two are an offset and a drift. A cable that
    gives way lets the carriage lag by $(f \,\mathrm{sign}\,\dot s + m \ddot s) / k$: without
    the sign and the acceleration beside them, a step forwards and its braking look like a
    clock that gains some milliseconds a second.

    Args:
        case: The campaign, signs and scales right.

    Returns:
        The terms, None if too little moves or the regression explains too little.
    """
    rows = [block for pair in pairings(case) for block in _blocks(pair)]
    if not rows:
        return None
    table = np.concatenate(rows)
    matrix, right = table[:, :-1], table[:, -1]
    size = matrix.std(axis=0)
    if not np.all(size > 0):
        return None
    matrix = matrix / size
    weight = np.ones(len(right))
    for _ in range(6):
        root = np.sqrt(weight)
        terms = np.linalg.lstsq(matrix * root[:, None], right * root, rcond=None)[0]
        error = right - matrix @ terms
        noise = spread(error)
        weight = huber(error, 2 * max(noise, 1e-12))
    terms = terms / size
    scale = float(terms[0])
    if noise > 0.05 * float(np.std(right)) or scale <= 0:
        return None
    power = np.linalg.pinv((matrix * weight[:, None]).T @ matrix, hermitian=True)
    errors = SURE * math.sqrt(ALIKE) * noise * np.sqrt(np.abs(np.diag(power))) / size / scale
    return ClockTerms(
        float(-terms[1]) / scale,
        float(-terms[2]) / scale,
        scale,
        float(errors[1]),
        float(errors[2]),
    )


def _blocks(pair: Pairing) -> list[Float64[np.ndarray, "frames 6"]]:
    blocks = []
    for base, column in ((pair.along, Q3), (pair.up, Y)):
        signal = pair.position[:, column]
        seen = np.isfinite(signal)
        if not pair.moves or travel(base) < 0.2 or seen.sum() < 30:
            continue
        speed = np.gradient(base, pair.time)
        elapsed = pair.time - pair.record.time[0]
        lags = np.gradient(speed, pair.time), np.tanh(speed / CREEP)
        block = np.stack([base, speed, speed * elapsed, *lags, signal], axis=1)[seen]
        blocks.append(block - block.mean(axis=0))
    return blocks
