r"""When a push began and ended, between the frames that a camera took of it.

Until the first swing is over the end-effector is an oscillator about the place $r(t)$ at which
its cables pull to neither side, which the camera tells by the carriages and the rotation:

$$ \ddot x = a\,[s \le t < s + d] - \omega^2 (x - r(t)) $$

Its answer is linear in the place at rest and in $a$. Middle, length $d$ and $\omega$ are a grid
of hypotheses, each with its likelihood, which closes in on those that count: the middle, since
it is known a hundred times better than $s$ and $d$, which make up for each other. So the begin
is known to a small part of a frame, with an error of its own: what the frames tell of it, and
what they leave to the usual length of a push by hand. The first frame out of the noise is
simpler and is late, by the way that the noise hides; where frames are many it is late by
several of them.
"""

import dataclasses
import math

import numpy as np
from jaxtyping import Float64

from identification.doctor.case import Q3, Q4, D, Record, Rig, X, Y
from identification.doctor.samples.motion import Onset

USUAL = 0.03
"""Duration of a push by hand [s], where the camera is too slow to tell."""

SPREAD = 0.7
"""Standard deviation of its logarithm [1]: pushes last 10 to 100 ms."""

WINDOWS = 0.1, 0.2, 0.4
"""How long after the first motion frames count [s]: for a short push, and for longer ones."""

FRAMES = 3.5
"""The same in frames, where they are few."""

PART = 0.7
"""Longest push over the window [1]: what is still pushed at its end can't be told from a
slower swing."""

BELOW = 0.9
"""Length over the longest one from which a longer window is looked at [1]."""

EARLY = 0.08
"""How much before the last frame at rest a push may begin [s]."""

RESTING = 40
"""Frames at rest that count: the place is known by then."""

PITCHES = (0.5, 12.0)
"""Lowest and highest frequency of the first swing [Hz]."""

POINTS = 17, 11, 11
"""Hypotheses of begin, length and frequency in each round."""

ROUNDS = 8
"""Rounds of the grid, each as wide as the one before left it."""

STEP = 1e-3
"""Step that the place of rest is followed with, and the shortest push [s]."""

CLOSE = 0.02
"""Least height of a cable that is reckoned with [m]."""

SHAPE = 0.1
"""What the begin of a push isn't known by, over its length [1]: a hand's push swells and ebbs,
and moves the end-effector as a steady one does that begins an eighth of its length later."""


@dataclasses.dataclass(frozen=True)
class Push:
    """A push as the frames tell it, on the drive's clock."""

    begin: float
    """When it began [s]."""
    begin_sigma: float
    """Standard error of that [s]."""
    length: float
    """How long it lasted [s]."""
    length_sigma: float
    """Standard error of that [s]."""


@dataclasses.dataclass(frozen=True, eq=False)
class _Window:
    """Frames about the first motion."""

    time: Float64[np.ndarray, " frames"]
    place: Float64[np.ndarray, " frames"]
    grid: Float64[np.ndarray, " steps"]
    """Instants at which the place of rest is known [s]."""
    pulled: Float64[np.ndarray, " steps"]
    """Place at which the cables pull straight, from where it was at rest [m]."""
    sigma: float
    """Noise of a position [m]."""


def push(record: Record, rig: Rig, moved: Onset) -> Push | None:
    """The push that fits the frames about the first motion.

    Args:
        record: The run, with frames that can be trusted, on clocks put right.
        rig: What is known of the rig.
        moved: The first frame out of the noise.

    Returns:
        The push, None where there are too few frames to fit one to.
    """
    for length in WINDOWS:
        window = _window(record, rig, moved, length)
        if window is None:
            return None
        longest = PART * float(window.time[-1] - moved.after)
        fitted = _fitted(window, moved, earliest=float(record.time[0]), longest=longest)
        if fitted.length < BELOW * longest:
            break
    return fitted


def _fitted(window: _Window, moved: Onset, *, earliest: float, longest: float) -> Push:
    """Means and standard deviations over the hypotheses that count."""
    low = np.array([max(moved.before - EARLY, earliest), math.log(STEP), math.log(PITCHES[0])])
    high = np.array([moved.after + longest / 2, math.log(longest), math.log(PITCHES[1])])
    first, last = low, high
    for _ in range(ROUNDS):
        axes = [np.linspace(a, b, n) for a, b, n in zip(first, last, POINTS, strict=True)]
        weight = _weights(window, *axes)
        middle, spread = np.array([_moments(a, w) for a, w in _along(axes, weight)]).T
        width = np.array([axis[1] - axis[0] for axis in axes])
        reach = np.maximum(4 * spread, 3 * width)
        first, last = np.maximum(middle - reach, low), np.minimum(middle + reach, high)
    lengths = np.exp(axes[1])
    begin, begin_sigma = _moments(axes[0][:, None] - lengths / 2, weight.sum(axis=2))
    length, length_sigma = _moments(lengths, weight.sum(axis=(0, 2)))
    return Push(begin, math.hypot(begin_sigma, SHAPE * length), length, length_sigma)


def _window(record: Record, rig: Rig, moved: Onset, length: float) -> _Window | None:
    """The frames from the rest before to the end of the first swing."""
    seen = np.isfinite(record.position[:, X])
    stamps = record.frame_time - record.offset
    frame = float(np.median(np.diff(stamps)))
    seen &= stamps <= moved.after + max(FRAMES * frame, length)
    rows = np.flatnonzero(seen)
    rest = int(np.count_nonzero(rows < moved.row))
    rows = rows[max(rest - RESTING, 0) :]
    # As many frames after the first one as there are numbers to find.
    if rest < 1 or len(rows) - min(rest, RESTING) < 3:
        return None
    time, place = stamps[rows], record.position[rows, X]
    grid = np.arange(time[0] - EARLY, time[-1] + STEP, STEP)
    pulled = _straight(record, rig, grid)
    return _Window(
        time=time,
        place=place,
        grid=grid,
        pulled=pulled - np.median(pulled[grid <= moved.before]),
        sigma=rig.position_sigma,
    )


def _straight(
    record: Record, rig: Rig, grid: Float64[np.ndarray, " steps"]
) -> Float64[np.ndarray, " steps"]:
    """Place of the end-effector at which the cables pull it to neither side [m]."""
    stamps = record.frame_time - record.offset
    tilt, lower, upper, y = (
        _followed(stamps, record.position[:, column], grid) for column in (D, Q3, Q4, Y)
    )
    below = np.maximum(y - rig.lower_offset, CLOSE)
    above = np.maximum(rig.height - y - rig.upper_offset, CLOSE)
    lower, upper = lower - rig.lower_offset * tilt, upper + rig.upper_offset * tilt
    return (lower * above + upper * below) / (above + below)


def _followed(
    stamps: Float64[np.ndarray, " frames"],
    column: Float64[np.ndarray, " frames"],
    grid: Float64[np.ndarray, " steps"],
) -> Float64[np.ndarray, " steps"]:
    seen = np.isfinite(column)
    if not seen.any():
        return np.zeros_like(grid)
    return np.interp(grid, stamps[seen], column[seen])


def _weights(
    window: _Window,
    centres: Float64[np.ndarray, " centres"],
    lengths: Float64[np.ndarray, " lengths"],
    pitches: Float64[np.ndarray, " pitches"],
) -> Float64[np.ndarray, "centres lengths pitches"]:
    """How likely each hypothesis is; lengths and pitches are logarithms."""
    costs = np.stack(
        [_costs(window, centres, np.exp(lengths), 2 * np.pi * math.exp(p)) for p in pitches], -1
    )
    # Where even the best one leaves more than noise, its residuals are the measure.
    freedom = max(len(window.time) - 5, 1)
    scale = max(float(costs.min()) / freedom, 1.0)
    usual = ((lengths - math.log(USUAL)) / SPREAD) ** 2
    log = -0.5 * ((costs - costs.min()) / scale + usual[:, None])
    weight = np.exp(log - log.max())
    return weight / weight.sum()


def _costs(
    window: _Window,
    centres: Float64[np.ndarray, " centres"],
    lengths: Float64[np.ndarray, " lengths"],
    omega: float,
) -> Float64[np.ndarray, "centres lengths"]:
    """Squares of what the best place and the best push leave, in units of the noise."""
    signal = (window.place - _carried(window, omega)) / window.sigma
    signal = signal - signal.mean()
    since = (window.time - centres[:, None])[:, None]
    half = lengths[:, None] / 2
    answer = _answer(since + half, omega) - _answer(since - half, omega)
    answer = answer - answer.mean(axis=-1, keepdims=True)
    square = np.sum(answer**2, axis=-1)
    along = answer @ signal
    return signal @ signal - along**2 / np.where(square > 0, square, np.inf)


def _answer(since: Float64[np.ndarray, "..."], omega: float) -> Float64[np.ndarray, "..."]:
    """What a push of 1 m/s^2 that lasts has moved after some time, in 1/omega^2."""
    return np.where(since > 0, 2 * np.sin(0.5 * omega * np.maximum(since, 0.0)) ** 2, 0.0)


def _carried(window: _Window, omega: float) -> Float64[np.ndarray, " frames"]:
    """How far the carriages' own motion has taken the end-effector by each frame [m]."""
    cosine, sine = math.cos(omega * STEP), math.sin(omega * STEP)
    x, v = 0.0, 0.0  # the place, and the speed over omega
    places = np.empty(len(window.grid))
    for step, rest in enumerate(window.pulled):
        away = x - rest
        x, v = rest + away * cosine + v * sine, v * cosine - away * sine
        places[step] = x
    return np.interp(window.time, window.grid + STEP, places)


def _along(
    axes: list[Float64[np.ndarray, " _"]],
    weight: Float64[np.ndarray, "centres lengths pitches"],
) -> list[tuple[Float64[np.ndarray, " _"], Float64[np.ndarray, " _"]]]:
    """Each axis with the weights along it."""
    return [
        (axis, weight.sum(axis=tuple(other for other in range(3) if other != k)))
        for k, axis in enumerate(axes)
    ]


def _moments(
    number: Float64[np.ndarray, "..."], weight: Float64[np.ndarray, "..."]
) -> tuple[float, float]:
    """Mean and standard deviation."""
    mean = float(np.sum(weight * number))
    return mean, float(np.sqrt(np.sum(weight * (number - mean) ** 2)))
