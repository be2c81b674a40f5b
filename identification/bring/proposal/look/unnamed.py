"""The camera's five columns where their names don't say which is which.

The rotation is small. The height isn't where the other three are, which move together. At rest
the end-effector hangs on the line between both carriages,

$$ x_e = q_3 + (q_4 - q_3) y_e / H, $$

and of the six ways to give three places to three columns one leaves nearly nothing of that.
"""

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from identification.bring.proposal.look.codes import CODES
from identification.bring.proposal.look.layouts import Group
from identification.bring.proposal.look.raw import length_unit
from identification.bring.proposal.look.roles import Role
from identification.bring.proposal.look.words import says
from identification.campaign.notes.note import rig_value
from identification.campaign.types import Campaign

REST = 6
"""Frames at a log's begin in which the robot rests: 0.2 s."""
SHAKEN = 4.0
"""Times what the carriages move from frame to frame that a knocked end-effector does [1]."""
METRES = {"m": 1.0, "cm": 100.0, "mm": 1000.0}
"""How many of a unit a metre is."""


def unnamed_camera(group: Group, given: Mapping[str, Role]) -> list[int]:
    """Columns that may be the camera's where names don't say which is which.

    Args:
        group: Columns that were logged together.
        given: The places that they got.

    Returns:
        The five columns, in the log's order; none where names say enough.
    """
    drive = ("t", "voltage_1", "voltage_2", "alpha_1", "alpha_2")
    taken = {id(given[name].signal) for name in drive if name in given}
    rest = [k for k, signal in enumerate(group.signals) if id(signal) not in taken]
    named = [
        name
        for name in ("x_e", "y_e", "delta_e")
        if name in given and says(given[name].signal.words, name) > 0
    ]
    return rest if len(rest) == 5 and len(named) < 2 else []


def camera_order(columns: Sequence[Sequence[np.ndarray]]) -> list[str]:
    """Which of five columns is which of the camera's, by their signals alone.

    Args:
        columns: Of each of the five its numbers in every log.

    Returns:
        The format's column of each.
    """
    seen = [
        [np.where(np.isin(log, CODES), np.nan, log)[: 10 * REST] for log in column]
        for column in columns
    ]
    middles = np.array([[_middle(log[:REST]) for log in column] for column in seen])
    turn = int(np.argmin(np.nanmax(np.abs(middles), axis=1)))
    rest = [k for k in range(5) if k != turn]
    apart = {
        k: sum(float(np.nanmean(np.abs(middles[k] - middles[m]))) for m in rest) for k in rest
    }
    height = max(apart, key=apart.get)
    unit, _ = length_unit([columns[k] for k in rest])
    frame = rig_value("frame_height", Campaign(name="", runs=())) * METRES.get(unit, 1000.0)
    share = middles[height] / frame

    def off(order: tuple[int, ...]) -> float:
        body, lower, upper = middles[list(order)]
        return float(np.nanmedian(np.abs(body - lower - (upper - lower) * share)))

    three = [k for k in rest if k != height]
    shaken = sorted(three, key=lambda k: -_shaking(columns[k]))
    orders = itertools.permutations(three)
    if _shaking(columns[shaken[0]]) > SHAKEN * _shaking(columns[shaken[1]]):
        # A knock shakes the end-effector, and hardly its carriages.
        orders = (order for order in orders if order[0] == shaken[0])
    body, lower, upper = min(orders, key=off)
    names = {turn: "delta_e", height: "y_e", body: "x_e", lower: "q_3", upper: "q_4"}
    return [names[k] for k in range(5)]


def _shaking(column: Sequence[np.ndarray]) -> float:
    """How far a column moves from frame to frame, in the log in which it does most."""
    steps = [np.diff(log[np.isfinite(log) & ~np.isin(log, CODES)]) for log in column]
    return max((float(np.sqrt(np.mean(s**2))) for s in steps if s.size), default=0.0)


def _middle(values: np.ndarray) -> float:
    """The middle of what was seen, NaN of nothing."""
    seen = values[np.isfinite(values)]
    return float(np.median(seen)) if seen.size else np.nan
