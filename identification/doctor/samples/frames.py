"""Frames that can't be motion: lost markers written as a value, and other markers."""

import dataclasses

import numpy as np
from jaxtyping import Bool, Float64

from identification.doctor.case import CAMERA_COLUMNS, Q3, Q4, D, Record, Rig, X, Y
from identification.doctor.findings import Finding
from identification.doctor.statistics import spread
from identification.doctor.words import finding

PLACES = (X, Y, Q3, Q4)
"""The columns that are places in the frame: a rotation of 0 is an everyday value."""

CODES = np.outer((0.0, -1.0, -999.0, 999.0, 9999.0, -9999.0), (1.0, 1e-2, 1e-3)).ravel()
"""What trackers write for a marker that they have lost, in m, cm and mm [m]."""

FAR = 20
"""Standard deviations from the column's median at which such a value is no place."""

BUMP = {X: 0.022, Y: 0.022, Q3: 0.035, Q4: 0.035}
"""What a knock moves within a frame and back [m]: carriages make bumps of 28 mm."""

CHANCE = 1e-2
"""Repeated frames that a run may have by chance, and still be told of one."""

MOST = 0.12
"""Share of the frames that may be other markers: with more it isn't single frames."""


def frames(record: Record, rig: Rig) -> tuple[Record, tuple[Finding, ...]]:
    """Lost markers that were written as a value, and frames that show another marker.

    Args:
        record: The run.
        rig: What is known of the rig.

    Returns:
        The run without these values, and what was found.
    """
    if not record.filmed:
        return record, ()
    position, found = record.position.copy(), []
    lost = _lost(position, rig) | _repeated(position)
    if lost.any():
        position[lost] = np.nan
        found.append(_finding(record, "lost_as_value", lost, "were written for a lost marker"))
    other = np.zeros(position.shape, dtype=bool)
    for column in PLACES:
        other[:, column] = _leaps(position[:, column], BUMP[column])
    if other.any():
        position[other] = np.nan
        found.append(_finding(record, "swapped_marker", other, "leap away and back"))
    return dataclasses.replace(record, position=position), tuple(found)


def _lost(position: Float64[np.ndarray, "frames 5"], rig: Rig) -> Bool[np.ndarray, "frames 5"]:
    """Cells of a tracker's code, and the rotation beside them."""
    lost = np.zeros(position.shape, dtype=bool)
    for column in PLACES:
        values = position[:, column]
        seen = values[np.isfinite(values)]
        if not seen.size:
            continue
        code = np.isclose(values[:, None], CODES, rtol=1e-12, atol=1e-12).any(axis=1)
        lost[:, column] = code & (np.abs(values - np.median(seen)) > FAR * rig.position_sigma)
    lost[:, D] = lost[:, [X, Y]].any(axis=1)
    # A column that is such a value throughout isn't a marker that was lost now and then.
    lost[:, lost.mean(axis=0) > 0.5] = False
    return lost


def _repeated(position: Float64[np.ndarray, "frames 5"]) -> Bool[np.ndarray, "frames 5"]:
    """Frames of which all places, or the end-effector's, repeat those of the frame before.

    A camera that rounds coarsely repeats single values at rest: how often each column does
    so by itself tells how likely it is that they do so together.
    """
    same = np.zeros(position.shape, dtype=bool)
    same[1:] = position[1:] == position[:-1]
    # A marker that was lost before stays so where a frame is repeated.
    kept = same.copy()
    kept[1:] |= np.isnan(position[1:]) & np.isnan(position[:-1])
    body, frame = (kept[:, list(columns)].all(axis=1) for columns in ((X, Y), PLACES))
    alone = same[~body].mean(axis=0) if (~body).any() else np.ones(5)
    often = np.where(same, alone, 1.0)
    lost = np.zeros(position.shape, dtype=bool)
    for repeated, columns, cells in ((body, (X, Y), (X, D, Y)), (frame, PLACES, range(5))):
        rare = len(position) * often[:, list(columns)].prod(axis=1) < CHANCE
        lost[np.ix_(repeated & rare, list(cells))] = True
    return lost


def _leaps(values: Float64[np.ndarray, " frames"], bump: float) -> Bool[np.ndarray, " frames"]:
    """Single frames far off both neighbours, and off the cubic through four of them.

    What is far is told by the run itself: by the scatter of such differences, by what one
    in seven of them reaches, and by what a knock moves within a frame and back. The worst
    goes first, because it spoils the judgement of its neighbours.
    """
    leaps = np.zeros(len(values), dtype=bool)
    if np.isfinite(values).sum() < 12:
        return leaps
    for _ in range(max(4, int(MOST * len(values)))):
        seen = np.flatnonzero(np.isfinite(values) & ~leaps)
        score, scale = _standing_out(values[seen])
        worst = int(np.argmax(score))
        if score[worst] < max(scale, bump):
            break
        leaps[seen[worst]] = True
    return leaps


def _standing_out(
    values: Float64[np.ndarray, " frames"],
) -> tuple[Float64[np.ndarray, " frames"], float]:
    """How far each frame stands out, alone or with the next one, and what is usual."""
    step = np.diff(values)
    single, lone = np.zeros(len(values)), np.zeros(len(values))
    lone[1:-1] = np.minimum(np.abs(step[:-1]), np.abs(step[1:])) * (step[:-1] * step[1:] < 0)
    inner = 4 * (values[1:-3] + values[3:-1]) - values[:-4] - values[4:]
    single[2:-2] = values[2:-2] - inner / 6
    usual = max(14 * spread(single), 7 * float(np.quantile(np.abs(single), 0.85)))
    score = np.minimum(np.abs(single), 1.5 * lone)
    # Two frames in a row: the cubic through two before and two after, at each of them.
    a, b, c, d, e, f = (values[k : len(values) - 5 + k] for k in range(6))
    first = c - (-0.3 * a + b + 0.5 * e - 0.2 * f)
    second = d - (-0.2 * a + 0.5 * b + e - 0.3 * f)
    apart = np.minimum(np.abs(c - b), np.abs(d - e)) * ((c - b) * (d - e) > 0)
    both = np.minimum(np.minimum(np.abs(first), np.abs(second)), 1.5 * apart)
    both[first * second < 0] = 0.0
    score[2:-3] = np.maximum(score[2:-3], both)
    score[3:-2] = np.maximum(score[3:-2], both)
    score[0], score[-1] = _end(values), _end(values[::-1])
    return score, usual


def _end(values: Float64[np.ndarray, " frames"]) -> float:
    """How far the first frame stands out of the four after it, if these stand still."""
    near = values[1:5]
    away = abs(float(values[0] - np.median(near)))
    return away if float(np.ptp(near)) < 0.1 * away else 0.0


def _finding(
    record: Record, identifier: str, cells: Bool[np.ndarray, "frames 5"], what: str
) -> Finding:
    rows = np.flatnonzero(cells.any(axis=1))
    columns = [name for name, hit in zip(CAMERA_COLUMNS, cells.any(axis=0), strict=True) if hit]
    noun = "value" if len(columns) == 1 else "values"
    return finding(
        identifier,
        "note",
        runs=[record.name],
        what=f"in {len(rows)} frames the {noun} of {', '.join(columns)} {what}",
        stream="camera",
        column=columns[0],
        row=int(rows[0]),
        evidence={"frames": rows[:8].tolist(), "count": len(rows)},
        mend={"do": "empty the cells", "run": record.name, "columns": columns},
    )
