"""Clocks and rates that aren't what the log states."""

import dataclasses
import math

import numpy as np

from identification.doctor.case import Case, Record
from identification.doctor.relations.clocks import alignment, clock_terms
from identification.doctor.relations.responses import responses
from identification.doctor.slips.edits import TIMES, Undone, affine, scaled
from identification.doctor.slips.scales import round_number
from identification.doctor.slips.slip import Slip

REACH = 1.0
"""How far off a stated clock is looked for [s], about what is stated and about a common
start of both streams."""

MEAN = 0.1
"""What a drift makes of an offset in the middle of a run, at most [s]."""

LARGEST_RATE = 50.0
"""Factor of a rate that is looked for; beyond it, it is a unit."""


def _offset(case: Case) -> Undone | None:
    film = case.filmed
    if not film:
        return None
    apart = [record.frame_time[0] - record.offset - record.time[0] for record in film]
    common = float(np.median(apart))
    about = common if abs(common) > REACH else 0.0
    shift = alignment(case, film, reach=REACH, step=0.04, about=about)
    if shift is None:
        return None

    def shifted(record: Record) -> Record:
        if not record.filmed:
            return record
        return dataclasses.replace(record, offset=record.offset + shift)

    step = {"do": "shift the camera's clock, and leave the rest to the fit", "by_s": -shift}
    return Undone(case.map(shifted), step, shift)


def _drift(case: Case) -> Undone | None:
    terms = clock_terms(case)
    if terms is None or abs(terms.drift) > 0.2:
        return None
    step = {"do": "scale", "columns": [TIMES[1]], "factor": 1 - terms.drift}
    straight = affine(case, TIMES[1:], 1 - terms.drift)
    found = [r for r in straight.filmed if r.offset_known and r.offset != r.run.clock_offset]
    # An offset that was found before the drift was its mean over the run.
    left = alignment(straight, found, reach=MEAN, step=MEAN / 5)
    moved = [dataclasses.replace(r, offset=r.offset + left) for r in found if left is not None]
    return Undone(straight.updated(moved), step, terms.drift)


def _rate(case: Case, *, simple: bool) -> Undone | None:
    """The drive's clock by a factor, from the streams' lengths.

    Without a camera the gain of the bare drives tells it: it goes with the square.
    """
    factors = [np.ptp(record.frame_time) / np.ptp(record.time) for record in case.filmed]
    if not factors:
        factors = [
            math.sqrt(response.nominal_gain / response.gain)
            for mode, response in responses(case).items()
            if mode.startswith("bare") and response.gain > 0
        ]
    factor = float(np.median(factors)) if factors else 1.0
    if not 1 / LARGEST_RATE < factor < LARGEST_RATE or abs(factor - 1) < 0.1:
        return None
    near = min(
        (ratio for whole in range(2, 26) for ratio in (float(whole), 1 / whole)),
        key=lambda ratio: abs(math.log(factor / ratio)),
    )
    is_near = abs(factor / near - 1) < 0.04
    if simple:
        return scaled(case, TIMES[:1], near) if is_near else None
    # The time base of one stream over the other's is all that they tell.
    undone = scaled(case, TIMES[:1], _refined(case, factor))
    return undone._replace(also=("clock.drift",)) if is_near else undone


def _refined(case: Case, factor: float) -> float:
    """A factor of the drive's clock so that no drift against the camera is left."""
    for _ in range(4):
        terms = clock_terms(affine(case, TIMES[:1], factor))
        if terms is None or abs(terms.drift) > 0.2:
            break
        factor *= 1 + terms.drift
    return round_number(factor, 1e-3 * factor)


RATES: tuple[Slip, ...] = (
    Slip("rate.drive", "a simple multiple of the rate", lambda case: _rate(case, simple=True)),
    Slip("rate.drive", "another rate", lambda case: _rate(case, simple=False)),
)
"""The drive's samples stamped at another rate."""

CLOCKS: tuple[Slip, ...] = (
    Slip("clock.offset", "the camera's clock", _offset),
    Slip("clock.drift", "the camera's clock", _drift),
)
"""The camera's clock."""
