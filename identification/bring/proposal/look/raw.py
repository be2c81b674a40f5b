"""What a column's own numbers tell: its unit by their size, wraps, values that mean lost."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64

from identification.bring.proposal.look.codes import CODES

Columns = Sequence[Float64[np.ndarray, " _"]]
PERIODS = (360.0, 2 * np.pi, 1.0, *(float(2**bits) for bits in range(8, 33)))
"""Where angles and counters wrap."""
_PERIODS = {"drive": (2e-5, 0.05), "camera": (1e-3, 0.3), "accelerometer": (1e-5, 0.05)}
"""Shortest and longest time between samples that a stream of this robot has [s]."""
_LENGTHS = (("m", 0.02, 3.0), ("cm", 10.0, 300.0), ("mm", 300.0, 3000.0))
"""Largest positions in a frame of 2 m by 1 m in each unit."""
_VOLTS = (("V", 0.3, 40.0), ("mV", 300.0, 40000.0))
"""Largest commands in each unit; the amplifiers take 10 V."""


def time_unit(columns: Columns, stream: str) -> tuple[str, str]:
    """The unit of a column of times.

    Args:
        columns: Its numbers, of each log.
        stream: "drive" or "camera".

    Returns:
        The unit, empty where none or several fit; and why.
    """
    shortest, longest = _PERIODS[stream]
    steps = [float(np.median(np.diff(column))) for column in columns]
    step = float(np.median(steps))
    length = max(float(np.ptp(column)) for column in columns)
    fitting = [
        unit
        for unit, scale in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9))
        if shortest < step * scale < longest and 0.1 <= length * scale <= 1e5
    ]
    if len(fitting) != 1:
        return "", f"a sample every {step:.4g}, which fits {' and '.join(fitting) or 'no unit'}"
    return fitting[0], f"a sample every {step:.4g}, over {length:.4g}"


def length_unit(columns: Sequence[Columns]) -> tuple[str, str]:
    """The unit of a camera's lengths.

    Args:
        columns: Numbers of x_e, y_e, q_3 and q_4, of each log.

    Returns:
        The unit, empty where none or several fit; and why.
    """
    return _by_size(columns, _LENGTHS, "positions")


def voltage_unit(columns: Sequence[Columns]) -> tuple[str, str]:
    """The unit of the commands.

    Args:
        columns: Numbers of both, of each log.

    Returns:
        The unit, empty where none or several fit; and why.
    """
    return _by_size(columns, _VOLTS, "commands")


def _by_size(
    columns: Sequence[Columns], known: Sequence[tuple[str, float, float]], what: str
) -> tuple[str, str]:
    size = max(_size(log) for column in columns for log in column)
    fitting = [unit for unit, low, high in known if low <= size < high]
    unit = fitting[0] if len(fitting) == 1 else ""
    if size == 0:
        return known[0][0], f"{what} of zero throughout, which any unit is"
    return unit, f"{what} up to {size:.4g}"


def _seen(column: Float64[np.ndarray, " _"]) -> Float64[np.ndarray, " seen"]:
    """Numbers that are there and mean nothing else."""
    return column[np.isfinite(column) & ~np.isin(column, CODES)]


def _size(column: Float64[np.ndarray, " _"], share: float = 0.98) -> float:
    """How large a column's numbers are, but for a few; 0 of nothing."""
    seen = np.abs(_seen(column))
    return float(np.quantile(seen, share)) if seen.size else 0.0


def rotation_unit(columns: Columns) -> tuple[str, str]:
    """The unit of the end-effector's rotation.

    Args:
        columns: Its numbers, of each log.

    Returns:
        The unit, and why: a camera's noise is 2 mrad or 0.1 degrees.
    """
    noise = float(np.median([_size(np.diff(_seen(column)), 0.5) for column in columns]))
    size = max(map(_size, columns))
    if size < 0.6 and noise < 0.02:
        return "rad", f"angles up to {size:.3g} with a noise of {noise:.2g}"
    if size > 1.2 or noise > 0.03:
        return "deg", f"angles up to {size:.3g} with a noise of {noise:.2g}"
    return "", f"angles up to {size:.3g} with a noise of {noise:.2g}, which fit both"


def wrap(columns: Columns) -> float | None:
    """Where an angle or a counter wraps.

    Args:
        columns: Its numbers, of each log.

    Returns:
        By how much it jumps, None where it doesn't.
    """
    seen = [column[np.isfinite(column)] for column in columns]
    largest = max(float(np.abs(np.diff(c)).max()) for c in seen if len(c) > 1)
    spread = max(float(np.ptp(c)) for c in seen)
    for period in sorted(PERIODS):
        if not 0.5 * period < largest <= spread <= 1.0001 * period:
            continue
        steps = [np.diff(c) for c in seen]
        rest = [np.abs(s - period * np.rint(s / period)).max() for s in steps]
        jumps = sum(int((np.abs(s) > 0.5 * period).sum()) for s in steps)
        if max(rest) < 0.2 * period and jumps <= 0.05 * sum(map(len, steps)):
            return period
    return None


def lost_codes(columns: Columns) -> tuple[float, ...]:
    """Numbers that mean that a marker wasn't seen.

    Args:
        columns: A camera's numbers, of each log.

    Returns:
        The codes that are there.
    """
    return tuple(code for code in CODES if any(_is_code(column, code) for column in columns))


def _is_code(column: Float64[np.ndarray, " samples"], code: float) -> bool:
    """Whether a number can't have been seen: it is far out, or rounder than noise allows."""
    at = column == code
    rest = column[np.isfinite(column) & ~np.isin(column, CODES)]
    if not at.any() or at.mean() > 0.5 or rest.size < 8:
        return False
    usual = float(np.quantile(np.abs(np.diff(rest)), 0.95))
    gap = max(float(rest.min()) - code, code - float(rest.max()))
    if gap > 4 * usual:
        return True
    # Of how many samples rounding would make exactly this number by chance.
    values = np.unique(rest)
    digit = float(np.min(np.diff(values))) if values.size > 1 else np.inf
    expected = digit * rest.size / max(2.5 * float(np.std(rest)), 1e-300)
    return bool(expected < 0.02 or (expected < 0.2 and at.sum() > 1))
