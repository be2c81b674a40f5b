r"""What the drives do with their commands, without differentiating an encoder.

The law is $\ddot\alpha = g V - d \dot\alpha - f\,\mathrm{sign}\,\dot\alpha$ with $g, d, f
\ge 0$. It is taken in weak form: multiplied by a triangle over two blocks of samples and
integrated by parts twice, the acceleration becomes a second difference of block ends, and
counts of an encoder are never differentiated. A reversed or exchanged signal leaves most of
the acceleration unexplained, because no gain is negative.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from identification.doctor.case import Case, Record, Rig
from identification.doctor.statistics import huber, non_negative, spread, travel

BLOCKS = 140
"""Blocks of a run: about as many as the slowest motion needs, and long against a count."""

ALWAYS = 0.05
"""Relative error of a ratio of gains whatever the law leaves: friction, and the blocks."""

BARE = 0.5
"""Relative error of a bare drive's gain for what its law leaves: ripple goes round with the
drive, and half of it averages out. That of the robot's is all that is left."""

FRICTION = 0.05
"""Share of the largest command that a drive's friction usually takes."""

LEFT = 0.0025
"""Share of the acceleration's power that is given up to keep friction to it."""


class _Rows(NamedTuple):
    """Weak form of a run: one row a triangle, one column a drive or a mode."""

    acceleration: Float64[np.ndarray, "rows 2"]
    voltage: Float64[np.ndarray, "rows 2"]
    speed: Float64[np.ndarray, "rows 2"]


class Response(NamedTuple):
    """What a drive, or a mode of both, does with its command."""

    gain: float
    """Acceleration for a volt [rad/(s² V)]."""
    decay: float
    """Deceleration for a speed [1/s]."""
    unexplained: float
    """Share of the acceleration's power that the law leaves."""
    nominal_gain: float
    """The gain of the rig as it is known [rad/(s² V)]."""
    nominal_decay: float
    """The decay of the rig as it is known [1/s]."""


MODES = ("bare 1", "bare 2", "sum", "difference")
"""Bare drives one by one; the robot along x (both forwards) and along y (against)."""


def responses(case: Case) -> dict[str, Response]:
    """The drives' responses in the modes that the runs excite.

    Args:
        case: The campaign.

    Returns:
        The responses by `MODES`, without those that nothing excites.
    """
    rows: dict[str, list[tuple[np.ndarray, ...]]] = {mode: [] for mode in MODES}
    for record in case.records:
        # Knocks push without a command, and a breakaway is friction and little else.
        if record.commanded and record.kind not in ("pseudo_impulse", "breakaway"):
            for mode, part in _modes(record, case.rig):
                rows[mode].append(part)
    found = {}
    for mode, parts in rows.items():
        gain = nominal_gain(case.rig, mode)
        fit = _fit(parts, FRICTION * gain * case.rig.voltage_limit) if parts else None
        if fit is not None:
            decay = gain * case.rig.damping / case.rig.torque_per_volt
            found[mode] = Response(*fit, gain, decay)
    return found


def nominal_gain(rig: Rig, mode: str) -> float:
    """Acceleration for a volt as the rig's nameplates have it.

    Args:
        rig: What is known of the rig.
        mode: One of `MODES`.

    Returns:
        The gain [rad/(s² V)].
    """
    if mode.startswith("bare"):
        return rig.torque_per_volt / rig.inertia
    mass = rig.moved_mass if mode == "sum" else rig.end_effector_mass
    return 2 * rig.torque_per_volt / (2 * rig.inertia + rig.radius**2 * mass)


def _modes(record: Record, rig: Rig) -> list[tuple[str, tuple[np.ndarray, ...]]]:
    rows = _weak_form(record)
    if rows is None:
        return []
    angle = record.angle[record.trusted]
    names = ("bare 1", "bare 2")
    if record.filmed or record.kind != "motor_step":
        both = np.array([[1.0, 1.0], [1.0, -1.0]])
        rows = _Rows(*(part @ both for part in rows))
        angle, names = angle @ both, ("sum", "difference")
    moved = [travel(angle[:, column]) for column in (0, 1)]
    enough = max(0.2 * max(moved), 60 * rig.count)
    return [
        (name, tuple(part[:, column] for part in rows))
        for column, name in enumerate(names)
        if moved[column] > enough
    ]


def _weak_form(record: Record) -> _Rows | None:
    # At least so long, or a slow log's accelerations are its encoder's rounding.
    size = math.ceil(len(record.time) / BLOCKS)
    count = len(record.time) // size - 1
    if count < 8:
        return None
    time = record.time[: (count + 1) * size : size]
    ends = record.angle[: (count + 1) * size : size]
    rise = ((np.arange(size) + 0.5) / size)[None, :, None]
    voltage = record.voltage[: count * size].reshape(count, size, 2)
    angle = record.angle[: count * size].reshape(count, size, 2)
    length = np.diff(time)
    middle = (length[1:] + length[:-1])[:, None] / 2
    regular = np.abs(length / (size * record.period) - 1) < 0.1
    whole = regular[1:] & regular[:-1] & record.trusted[size : count * size : size]
    under = ((voltage[:-1] * rise).sum(axis=1) + (voltage[1:] * (1 - rise)).sum(axis=1)) / size
    speed = np.diff(angle.mean(axis=1), axis=0) / middle
    bend = (ends[2:] - 2 * ends[1:-1] + ends[:-2]) / middle**2
    return _Rows(bend[whole], under[whole], speed[whole])


def _fit(
    parts: Sequence[tuple[np.ndarray, ...]], friction: float
) -> tuple[float, float, float] | None:
    """Gain, decay and unexplained share of the robust non-negative fit.

    While a command is held, friction and a smaller gain are the same thing. So friction is
    held near zero, by what it usually is, as much as `LEFT` of the acceleration's power.
    """
    bend, voltage, speed = (np.concatenate(column) for column in zip(*parts, strict=True))
    fastest = float(np.max(np.abs(speed), initial=1e-12))
    largest = float(np.max(np.abs(bend), initial=1e-12))
    # At rest the friction is what it needs to be: the law says nothing.
    live = (np.abs(speed) > 0.01 * fastest) | (np.abs(bend) > 0.02 * largest)
    bend, voltage, speed = bend[live], voltage[live], speed[live]
    if len(bend) < 12 or not np.any(bend):
        return None
    turning = np.clip(speed / (0.02 * np.max(np.abs(speed))), -1, 1)
    matrix = np.stack([voltage, -speed, -turning], axis=1)
    size = np.sqrt(np.mean(matrix**2, axis=0))
    size[size == 0] = 1.0
    matrix = matrix / size
    prior = np.zeros((1, 3))
    prior[0, 2] = math.sqrt(LEFT * float(np.sum(bend**2))) / (friction * size[2])
    weight = np.ones(len(bend))
    for _ in range(3):
        root = np.sqrt(weight)
        rows = np.concatenate([matrix * root[:, None], prior])
        terms = non_negative(rows, np.append(bend * root, 0.0))
        error = bend - matrix @ terms
        weight = huber(error, 2.5 * max(spread(error), 0.02 * float(np.max(np.abs(bend)))))
    terms = terms / size
    share = float(np.sum(weight * error**2) / np.sum(weight * bend**2))
    return float(terms[0]), float(terms[1]), share


def plain_gain(record: Record) -> float | None:
    """Acceleration for a volt of a run whose drives do the same, friction not taken apart.

    In one step, friction and a smaller gain are the same thing: to compare runs, the gain
    must not depend on how they are shared out.

    Args:
        record: The run.

    Returns:
        The mean of both drives' gains [rad/(s² V)]; None if nothing moves.
    """
    rows = _weak_form(record)
    if rows is None:
        return None
    gains = []
    for drive in (0, 1):
        bend, voltage, speed = (part[:, drive] for part in rows)
        matrix = np.stack([voltage, -speed], axis=1)
        size = np.sqrt(np.mean(matrix**2, axis=0))
        if np.all(size > 0):
            gains.append(float(non_negative(matrix / size, bend)[0] / size[0]))
    return math.fsum(gains) / len(gains) if gains else None


class Inertia(NamedTuple):
    """Inertia of the drives from gains, and what it says of the command's unit."""

    value: float
    """Inertia of a drive [kg m²]."""
    ratio: float
    """Torque per volt over the one that is known."""
    error: float
    """Relative error that this ratio may have."""


def drive_inertia(case: Case, found: dict[str, Response]) -> Inertia | None:
    r"""Inertia of the drives from two gains whose ratio doesn't know the command's unit.

    Bare: $g_b = k_V / J$; along y: $g_d = 2 k_V / (2 J + r^2 m_e)$. Their ratio $x = g_b / g_d$
    gives $J = r^2 m_e / (2 (x - 1))$, and $k_V = g_b J$ is then held against its value. An
    error of $x$ counts $x / (x - 1)$ times, which is 3 on the paper's rig and 8 where the
    drives are heavy; what the law leaves of the acceleration tells how large it may be.

    Args:
        case: The campaign.
        found: Its responses.

    Returns:
        The inertia; None without both kinds of runs.
    """
    rig = case.rig
    bare = [found[mode] for mode in ("bare 1", "bare 2") if mode in found]
    cable = found.get("difference")
    if not bare or cable is None or cable.unexplained > 0.2:
        return None
    if not min(each.gain for each in bare) > 1.05 * cable.gain > 0:
        return None
    gain = math.fsum(each.gain for each in bare) / len(bare)
    inertia = rig.radius**2 * rig.end_effector_mass / (2 * (gain / cable.gain - 1))
    left = cable.unexplained + BARE * max(each.unexplained for each in bare)
    error = (ALWAYS + left) / (1 - cable.gain / gain)
    return Inertia(inertia, gain * inertia / rig.torque_per_volt, error)
