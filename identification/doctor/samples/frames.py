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
        other[:, column] = _leaps(record.frame_time, position[:, column], BUMP[column])
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


def _leaps(
    time: Float64[np.ndarray, " frames"], values: Float64[np.ndarray, " frames"], bump: float
) -> Bool[np.ndarray, " frames"]:
    """Single frames, and two in a row, that their neighbours don't allow.

    What is far is told by the run itself: by the scatter of such differences, by what two
    in five of them reach, and by what a knock moves within a frame and back. The worst
    goes first, because it spoils the judgement of its neighbours.
    """
    leaps = np.zeros(len(values), dtype=bool)
    if np.isfinite(values).sum() < 12:
        return leaps
    place = np.rint((time - time[0]) / np.median(np.diff(time))).astype(int)
    # Two stamps that jitter into one place, or a clock that stands still, are no grid.
    if place[-1] > 4 * len(values) or np.any(np.diff(place) < 1):
        place = np.arange(len(values))
    for _ in range(max(4, int(MOST * len(values)))):
        seen = np.flatnonzero(np.isfinite(values) & ~leaps)
        even = np.interp(np.arange(place[-1] + 1), place[seen], values[seen])
        score, usual = _standing_out(even)
        score = score[place[seen]]
        worst = int(np.argmax(score))
        if score[worst] < max(usual, bump):
            break
        leaps[seen[worst]] = True
    return leaps


def _standing_out(
    values: Float64[np.ndarray, " frames"],
) -> tuple[Float64[np.ndarray, " frames"], float]:
    """How far each frame stands out, alone or with the next one, and what is usual.

    A frame stands out by itself if neither the cubic through four neighbours explains it,
    nor the run's own vibration.
    """
    score = np.zeros(len(values))
    inner = 4 * (values[1:-3] + values[3:-1]) - values[:-4] - values[4:]
    single = np.abs(values[2:-2] - inner / 6)
    single[1:-1] = np.minimum(single[1:-1], np.abs(_off_vibration(values)))
    usual = max(14 * spread(single), 7 * float(np.quantile(single, 0.6)))
    score[2:-2] = single
    # Two frames in a row: the cubic through two before and two after, at each of them.
    a, b, c, d, e, f = (values[k : len(values) - 5 + k] for k in range(6))
    first = c - (-0.3 * a + b + 0.5 * e - 0.2 * f)
    second = d - (-0.2 * a + 0.5 * b + e - 0.3 * f)
    apart = np.minimum(np.abs(c - b), np.abs(d - e)) * ((c - b) * (d - e) > 0)
    both = np.minimum(np.minimum(np.abs(first), np.abs(second)), 1.5 * apart)
    both[first * second < 0] = 0.0
    score[2:-3] = np.maximum(score[2:-3], both)
    score[3:-2] = np.maximum(score[3:-2], both)
    score[0], score[1] = _ends(values)
    score[-1], score[-2] = _ends(values[::-1])
    return score, usual


def _off_vibration(values: Float64[np.ndarray, " frames"]) -> Float64[np.ndarray, " inner"]:
    r"""Each frame less what the three before and the three after make of it.

    A sum of two vibrations and a place obeys $x_i = \sum_k c_k (x_{i-k} + x_{i+k})$ with the
    same three $c_k$ all along, of which $\sum_k 2 c_k = 1$ leaves two to be estimated. Frames
    that don't obey hardly count in their estimate.
    """
    near, next_, far = (
        (values[3 - k : len(values) - 3 - k] + values[3 + k : len(values) - 3 + k])
        for k in (1, 2, 3)
    )
    matrix = np.stack([next_ - near, far - near], axis=1)
    right = values[3:-3] - near / 2
    # It begins as the cubic.
    terms = np.array([-1 / 6, 0.0])
    for _ in range(6):
        error = right - matrix @ terms
        weight = 1 / (1 + np.square(error / max(2 * spread(error), 1e-9)))
        power = (matrix * weight[:, None]).T @ matrix
        power += np.eye(2) * (1e-9 * np.trace(power) + 1e-300)
        terms = np.linalg.solve(power, (matrix * weight[:, None]).T @ right)
    return right - matrix @ terms


def _ends(values: Float64[np.ndarray, " frames"]) -> tuple[float, float]:
    """How far the first frame and the second are off parabolas through their neighbours.

    What an extrapolation is off by counts a third: it amplifies what is wrong with others.
    Where the next frames stand still, it counts in full.
    """
    a, b, c, d = values[:4]
    near = values[1:5]
    away = abs(float(a - np.median(near)))
    still = float(np.ptp(near)) < 0.1 * away
    first = abs(float(a - 3 * b + 3 * c - d)) / 3
    return max(first, away) if still else first, abs(float(b - a / 3 - c + d / 3))


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
