"""Which column of a log is which column of the format, and why.

Every column is scored for every place by its name, its unit and its looks, and the places
are given out together: a name such as "theta" is an encoder's beside voltages and the
end-effector's beside positions, and which it is shows only when all are looked at at once.
"""

import dataclasses

import numpy as np
import scipy.optimize

from identification.bring.proposal.look.layouts import Group
from identification.bring.proposal.look.signals import Looks, Signal
from identification.bring.proposal.look.words import (
    CAMERA,
    INDEX,
    LOWER,
    UPPER,
    place,
    says,
    tokens,
)
from identification.bring.streams.units import unit_scale
from identification.campaign.tables.columns import ACCELEROMETER, Column, drive_columns
from identification.campaign.tables.columns import CAMERA as CAMERA_COLUMNS

SLOTS: tuple[tuple[str, str], ...] = (
    ("voltage_1", "voltage"),
    ("voltage_2", "voltage"),
    ("alpha_1", "alpha"),
    ("alpha_2", "alpha"),
    ("current_1", "current"),
    ("current_2", "current"),
    ("tension", "tension"),
    ("x_ref", "ref"),
    ("y_ref", "ref"),
    ("x_e", "x_e"),
    ("y_e", "y_e"),
    ("delta_e", "delta_e"),
    ("q_3", "carriage"),
    ("q_4", "carriage"),
    ("a_x", "accelerometer"),
    ("a_y", "accelerometer"),
    ("a_z", "accelerometer"),
)
"""Columns that are given out, each with its concept."""
PAIRS = (("voltage_1", "voltage_2"), ("alpha_1", "alpha_2"), ("current_1", "current_2"))
"""Columns of drive 1 and drive 2."""
OPTIONAL = ("current_1", "current_2", "tension", "x_ref", "y_ref", "a_y", "a_z")
"""Columns that need not be there: a name has to say them."""
ENOUGH = 2.0
"""Score from which on a column is given a place [1]."""
FAR = -8.0
"""Score of a unit that a place can't have [1]."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Role:
    """A column of a log with its place."""

    signal: Signal
    """The column."""
    looks: Looks
    """What it looks like."""
    why: str
    """Why it is thought to be that."""


def roles(group: Group) -> dict[str, Role]:
    """The places of a group's columns.

    Args:
        group: Columns that were logged together.

    Returns:
        Columns of the format, `t` among them, with those of the log.
    """
    time = _time(group)
    rest = [k for k in range(len(group.signals)) if k != time]
    given = {} if time is None else {"t": _role(group, time, "t", "")}
    if not rest:
        return given
    score = np.array([[_score(group, k, slot) for slot in SLOTS] for k in rest])
    # A column may stay without a place, at the price of what is just not enough.
    idle = np.full((len(rest), len(rest)), ENOUGH)
    rows, columns = scipy.optimize.linear_sum_assignment(-np.hstack([score, idle]))
    for row, column in zip(rows, columns, strict=True):
        if column < len(SLOTS) and score[row, column] > ENOUGH:
            name, concept = SLOTS[column]
            given[name] = _role(group, rest[row], name, concept)
    return _ordered(given)


def _role(group: Group, k: int, name: str, concept: str) -> Role:
    signal, seen = group.signals[k], group.looks[k]
    reasons = []
    if concept and says(signal.words, concept):
        reasons.append(f"its name {signal.words!r}")
    if set(tokens(signal.above)) & CAMERA and name in ("x_e", "y_e", "delta_e", "q_3", "q_4"):
        reasons.append(f"it stands below {signal.above!r}")
    if signal.unit:
        reasons.append(f"its unit {signal.unit!r}")
    reasons += _look_reasons(seen, name)
    return Role(signal=signal, looks=seen, why=", ".join(reasons) or "nothing else fits")


def _look_reasons(seen: Looks, name: str) -> list[str]:
    if name == "t":
        return ["it grows in even steps"] if seen.even else ["it grows"]
    if name.startswith("voltage") and seen.starts_at_zero > 0.5 and seen.jump > 0.2:
        return ["it begins at zero and jumps"]
    if name.startswith("alpha") and seen.whole:
        return ["whole numbers that stand still and then move"]
    if name.startswith("alpha") and seen.jump < 0.1:
        return ["it moves without jumps"]
    return []


def _time(group: Group) -> int | None:
    """Which column is the time."""
    scores = []
    for signal, seen in zip(group.signals, group.looks, strict=True):
        named = says(signal.words, "t") + (3.0 if signal.is_stamp else 0.0)
        named += 2.0 * (_fits(signal.unit, CAMERA_COLUMNS[0]) or 0)
        counts_rows = seen.step == 1 and bool(set(tokens(signal.words)) & INDEX)
        scores.append(named + 2.0 * seen.even - 4.0 * counts_rows if seen.increases else -1.0)
    best = int(np.argmax(scores))
    return best if scores[best] >= ENOUGH else None


def _fits(unit: str, column: Column) -> int | None:
    """Whether a unit is a column's: 1 or -1, None where there is no unit."""
    if not unit.strip(" -1"):
        return None
    return 1 if unit_scale(column, unit) is not None else -1


_KNOWN = {
    column.name: column for column in (*drive_columns(1.0), *CAMERA_COLUMNS, *ACCELEROMETER)
}


def _score(group: Group, k: int, slot: tuple[str, str]) -> float:
    """How well a column fits a place."""
    (name, concept), signal, seen = slot, group.signals[k], group.looks[k]
    fits = _fits(signal.unit, _KNOWN[name])
    if fits == -1:
        return FAR
    named = says(signal.words, concept)
    if concept == "accelerometer":
        return _accelerometer_score(signal, name, named, fits)
    if name in OPTIONAL:
        return named + 1.0 * (fits or 0) if named >= 1.5 else FAR
    score = named + 2.0 * (fits or 0)
    camera = name in ("x_e", "y_e", "delta_e", "q_3", "q_4")
    around = bool((set(tokens(signal.above)) | set(tokens(signal.words))) & CAMERA)
    score += (1.5 if around else 0.0) if camera else (-1.0 if around else 0.0)
    score -= 3.0 * (says(signal.words, "ref") >= 1.5)
    if camera:
        score += _camera_score(signal, seen, name)
    elif name.startswith("voltage"):
        score += 0.8 * (seen.starts_at_zero > 0.5) + 1.2 * (seen.jump > 0.2)
        score += 0.5 * (seen.repeats > 0.2) - 2.0 * (seen.whole and seen.jump < 0.2)
    else:
        score += 2.5 * seen.whole * (seen.starts_still > 0.5) + 1.0 * (seen.jump < 0.1)
        score += 0.5 * (seen.starts_still > 0.5)
    return score


def _accelerometer_score(signal: Signal, name: str, named: float, fits: int | None) -> float:
    """What of a column's name and unit fits an axis of an accelerometer."""
    words = set(tokens(signal.words))
    if named < 1.5 and not fits:
        return FAR
    axis = name[-1]
    others = words & ({"x", "y", "z"} - {axis})
    return named + 3.0 * (fits or 0) + 1.5 * (axis in words) - 4.0 * bool(others)


def _camera_score(signal: Signal, seen: Looks, name: str) -> float:
    """What of a column's name and looks fits a place of the camera's."""
    words = set(tokens(signal.words))
    # A camera's noise never gives the same number twice, but for codes of lost markers.
    score = 0.5 - 1.5 * (seen.repeats > 0.3) - 1.0 * (seen.whole and seen.starts_still > 0.5)
    if name == "q_3":
        score += 2.0 * bool(words & LOWER) - 2.0 * bool(words & UPPER - {"u"})
    elif name == "q_4":
        score += 2.0 * bool(words & UPPER) - 2.0 * bool(words & LOWER - {"l"})
    elif says(signal.words, "carriage") >= 1.5:
        score -= 2.0
    if name in ("x_e", "y_e"):
        axis = name[0]
        score += 1.0 * (axis in words) - 1.5 * ("xy".replace(axis, "") in words)
    return score


def _ordered(given: dict[str, Role]) -> dict[str, Role]:
    """Drives 1 and 2, and both carriages, in the order of their numbers and sides."""
    for first, second in (*PAIRS, ("q_3", "q_4")):
        if first in given and second in given:
            words = [given[name].signal.words for name in (first, second)]
            told = [set(tokens(each)) for each in words]
            if first == "q_3" and (told[0] & LOWER or told[1] & UPPER):
                continue
            if place(words) == [1, 0]:
                given[first], given[second] = given[second], given[first]
    return given
