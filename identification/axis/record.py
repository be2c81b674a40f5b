"""An axis's log as a fit sees it: its pieces, how each begins, and how exact its positions are.

Where samples are missing nobody knows what was commanded, so the axis is simulated anew behind
the gap. An axis that moves as a piece begins has a velocity there that is estimated with the
rest; taking it for rest bends inertia and friction into what has to explain it. Velocities on
the way, where shorter predictions begin, are those of local cubics as long as the noise asks.
"""

import dataclasses
import functools
import itertools

import numpy as np
from jaxtyping import Float64, Int

from identification.axis.jumps import jumps, resolution
from identification.axis.log import AxisLog

GAP = 3.0
"""Periods between two samples from which some are missing [1]."""

SHORTEST = 16
"""Samples that a piece has at least to be fitted."""

MOVING = 0.08
"""Speed at the record's begin over the largest one from which it doesn't begin at rest [1]."""

MOVING_ON = 0.02
"""The same behind a gap, before which the axis had been moving."""

FIRST = 8
"""Samples by which that speed is judged: a slope through fewer is the encoder's rounding."""

HALF_WINDOWS = (3, 10, 30)
"""Samples to either side in a local cubic."""

NO_WORSE = 1.2
"""Scatter about a wide cubic over that about the narrowest up to which it follows [1]."""

_TURNED = 6.0
"""Way back over the positions' noise from which an axis has turned round [1]."""

_CUBIC = 3


@dataclasses.dataclass(frozen=True)
class Piece:
    """Samples that follow one another without a gap."""

    start: int
    """First sample."""
    end: int
    """Sample behind the last one."""
    moves: bool
    """Whether the axis moves as it begins."""

    def __len__(self) -> int:
        return self.end - self.start


@dataclasses.dataclass(frozen=True, eq=False)
class AxisRecord:
    """An axis's log, divided where it has gaps."""

    log: AxisLog
    """The log."""
    pieces: tuple[Piece, ...]
    """The pieces that are long enough to be fitted."""
    velocity: Float64[np.ndarray, " samples"]
    """Velocities by local cubics [m/s or rad/s]."""
    noise: float
    """Standard deviation of the positions' noise and rounding [m or rad]."""
    velocity_noise: float
    """The same of the velocities [m/s or rad/s]."""
    notes: tuple[str, ...]
    """What is remarkable about the log, a sentence each."""

    @functools.cached_property
    def direction(self) -> int:
        """1 of an axis that only moves forwards, -1 of one that moves back alone, else 0."""
        parts = [self.position[piece.start : piece.end] for piece in self.pieces]
        back = max(float(np.max(np.maximum.accumulate(own) - own)) for own in parts)
        forth = max(float(np.max(own - np.minimum.accumulate(own))) for own in parts)
        least = _TURNED * self.noise
        return int(back <= least) - int(forth <= least)

    @functools.cached_property
    def time(self) -> Float64[np.ndarray, " samples"]:
        """Times of the samples [s]."""
        return np.asarray(self.log.time)

    @functools.cached_property
    def position(self) -> Float64[np.ndarray, " samples"]:
        """Measured positions [m or rad]."""
        return np.asarray(self.log.position)

    @functools.cached_property
    def piece_of(self) -> Int[np.ndarray, " samples"]:
        """Number of the piece that each sample belongs to; -1 for none."""
        number = np.full(len(self.time), -1)
        for k, piece in enumerate(self.pieces):
            number[piece.start : piece.end] = k
        return number

    @functools.cached_property
    def motion(self) -> float:
        """Root mean square of the positions about each piece's mean [m or rad]."""
        parts = [self.position[p.start : p.end] for p in self.pieces]
        spread = np.concatenate([part - np.mean(part) for part in parts])
        return float(np.sqrt(np.mean(spread**2)))


def axis_record(log: AxisLog) -> AxisRecord:
    """A log divided into its pieces.

    Args:
        log: The log.

    Returns:
        The record.

    Raises:
        ValueError: If no piece is long enough to be fitted.
    """
    time, position = np.asarray(log.time), np.asarray(log.position)
    period = float(np.median(np.diff(time)))
    lost = np.diff(time) > GAP * period
    jumped = jumps(time, position) & ~lost
    edges = [0, *(np.flatnonzero(lost | jumped) + 1).tolist(), len(time)]
    spans = [(a, b) for a, b in itertools.pairwise(edges) if b - a >= SHORTEST]
    if not spans:
        raise ValueError(
            f"no stretch of the log has {SHORTEST} samples without a gap, got the longest of "
            f"{max(np.diff(edges))}, expected more. Log without interruptions."
        )
    velocity, noise, velocity_noise = _velocity(position, spans, period)
    fastest = max(float(np.quantile(np.abs(velocity[a:b]), 0.99)) for a, b in spans)
    pieces = tuple(
        Piece(a, b, _speed(time, position, a) > (MOVING_ON if a else MOVING) * fastest)
        for a, b in spans
    )
    notes = (*log.notes, *_notes(log, pieces, np.flatnonzero(lost), np.flatnonzero(jumped)))
    return AxisRecord(log, pieces, velocity, noise, velocity_noise, notes)


def _velocity(
    position: Float64[np.ndarray, " samples"], spans: list[tuple[int, int]], period: float
) -> tuple[Float64[np.ndarray, " samples"], float, float]:
    """Velocities by the widest local cubics that follow the motion, and the noise of both."""
    # It brings `scipy.stats`, which takes as long to load as all else of a fit.
    from scipy.signal import savgol_coeffs, savgol_filter

    scatter: dict[int, float] = {}
    velocities: dict[int, Float64[np.ndarray, " samples"]] = {}
    for half in HALF_WINDOWS:
        window = 2 * half + 1
        if window > min(b - a for a, b in spans):
            break
        # A cubic through a window's middle takes this share of the noise with it.
        weight = savgol_coeffs(window, _CUBIC)[half]
        velocity, left = np.zeros(len(position)), []
        for a, b in spans:
            part = position[a:b]
            smooth = savgol_filter(part, window, _CUBIC)
            left.append((part - smooth)[half : len(part) - half])
            velocity[a:b] = savgol_filter(part, window, _CUBIC, deriv=1, delta=period)
        scatter[half] = float(np.sqrt(np.mean(np.concatenate(left) ** 2) / (1 - weight)))
        velocities[half] = velocity
    least = resolution(position) / np.sqrt(12)
    noise = max(scatter[HALF_WINDOWS[0]], least)
    widest = max(half for half, size in scatter.items() if size <= NO_WORSE * noise)
    slope = savgol_coeffs(2 * widest + 1, _CUBIC, deriv=1, delta=period)
    return velocities[widest], noise, noise * float(np.linalg.norm(slope))


def _speed(
    time: Float64[np.ndarray, " samples"], position: Float64[np.ndarray, " samples"], start: int
) -> float:
    """Speed of the first samples of a piece [m/s or rad/s]."""
    first = slice(start, start + FIRST)
    return abs(float(np.polyfit(time[first] - time[start], position[first], 1)[0]))


def _notes(
    log: AxisLog,
    pieces: tuple[Piece, ...],
    lost: Int[np.ndarray, " gaps"],
    jumped: Int[np.ndarray, " jumps"],
) -> list[str]:
    """What is remarkable about the pieces; rows count from 1 below the header."""
    time, position = np.asarray(log.time), np.asarray(log.position)
    notes, unit = [], log.position_unit
    period = float(np.median(np.diff(time)))
    for row in lost[:3]:
        gap = float(time[row + 1] - time[row])
        notes.append(
            f"Samples are missing after row {row + 1}: a gap of {gap:.3g} s at t = "
            f"{time[row]:.4g} s, {round(gap / period)} periods. What was commanded meanwhile "
            "isn't known: the axis is simulated anew behind it."
        )
    if len(lost) > len(lost[:3]):
        notes.append(f"There are {len(lost)} such gaps in all.")
    for row in jumped[:3]:
        jump = float(position[row + 1] - position[row])
        notes.append(
            f"The position jumps by {jump:.4g} {unit} after row {row + 1}, at t = "
            f"{time[row]:.4g} s, which is no motion: the axis is simulated anew behind it. "
            "Check whether the encoder loses counts."
        )
    if pieces[0].moves:
        notes.append(
            f"The axis moves already as the record begins, at t = {time[pieces[0].start]:.4g} "
            "s: its velocity there is estimated, too."
        )
    return notes
