r"""What the camera says of the encoders: their unit, or the counts of a turn.

$$ \alpha_{1,2} = c + k (q_3 \pm y_e) / r $$

with one k for both, which is 1 where the numbers are radians.
"""

import math
from collections.abc import Sequence

import numpy as np

from identification.campaign.notes.note import rig_value
from identification.campaign.types import Campaign, Run

UNITS = (("rad", 1.0), ("deg", 180 / math.pi), ("rev", 0.5 / math.pi))
"""How large a radian is in each unit."""
CLOSE = 0.12
"""Logarithm that a radius other than the paper's may make [1]."""
TRAVEL = 0.02
"""Travel that a run must have to tell anything [m]."""


def numbers_a_radian(runs: Sequence[Run], campaign: Campaign) -> float | None:
    """How many of their numbers the encoders count for a radian, by the camera.

    Args:
        runs: Recordings whose angles are the log's own numbers.
        campaign: What is known of the rig, for the radius of the pulleys.

    Returns:
        The number, None where no camera tells it.
    """
    radius = rig_value("effective_radius", campaign)
    slopes, weights = [], []
    for run in runs:
        if run.camera is None:
            continue
        time = run.camera.time - (run.clock_offset or 0.0)
        inside = (time >= run.drive.time[0]) & (time <= run.drive.time[-1])
        place = run.camera.position[:, [2, 4]]
        inside &= np.isfinite(place).all(axis=1)
        place = place[inside]
        if len(place) < 8 or np.ptp(place, axis=0).max() < TRAVEL:
            continue
        basis = np.column_stack([place, np.ones(len(place))])
        for column in run.drive.angle.T:
            there = np.interp(time[inside], run.drive.time, column)
            (along, up, _), *_ = np.linalg.lstsq(basis, there, rcond=None)
            for slope, travel in zip((along, up), np.std(place, axis=0), strict=True):
                if travel > TRAVEL / 4:
                    slopes.append(abs(slope) * radius)
                    weights.append(travel)
    if not slopes:
        return None
    order = np.argsort(slopes)
    share = np.cumsum(np.array(weights)[order])
    return float(np.array(slopes)[order][np.searchsorted(share, share[-1] / 2)])


def unit_of(number: float | None, *, whole: bool) -> tuple[str, str]:
    """The encoders' unit.

    Args:
        number: What they count for a radian, None where nothing tells it.
        whole: Whether their numbers are whole.

    Returns:
        The unit, empty where nothing tells it; and why.
    """
    if whole:
        return "count", "whole numbers"
    if number is None:
        return "", "no camera tells how far the pulleys turn"
    for unit, size in UNITS:
        if abs(math.log(number / size)) < CLOSE:
            return unit, f"the camera sees {number:.4g} of them for a radian"
    return "", f"the camera sees {number:.4g} of them for a radian, which is no unit"
