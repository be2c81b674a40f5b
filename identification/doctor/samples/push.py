r"""When a push began and ended, between the frames that a camera took of it.

Until the first swing is over the end-effector is an oscillator about the place $r(t)$ at which
its cables pull to neither side, which the camera tells by the carriages and the rotation:

$$ \ddot x = a\,p((t - s) / d) - \omega^2 (x - r(t)) $$

The shape $p$ is steady, as an actuator's, or half a sine, as a hand's. The answer is linear in
the place at rest and in $a$. Middle, length $d$ and $\omega$ are a grid of hypotheses for each
shape, each with its likelihood, which closes in on those that count: the middle, since it is
known a hundred times better than $s$ and $d$, which make up for each other. Shapes count by
their evidence. So the begin is known to a small part of a frame, with an error of its own: what
the frames tell of it, and what they leave to the shape and to the usual length of a push.

The first frame out of the noise is simpler and is late, by the way that the noise hides; where
frames are many it is late by several of them. A shape left wholly open would tell no begin: a
push that sets in softly moves nothing that noise doesn't hide for a third of its length.
"""

import dataclasses
import math

import numpy as np
from jaxtyping import Float64

from identification.doctor.case import Q3, Q4, D, Record, Rig, X, Y
from identification.doctor.samples.motion import Onset
from scdpr_jax.numerics.levenberg_marquardt import Stopping, minimise
from scdpr_jax.numerics.merit import SumOfSquares

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

REST = 2.0
"""How long before the first motion they are at most [s]: a clock's unit may be wrong."""

PITCHES = (0.5, 12.0)
"""Lowest and highest frequency of the first swing [Hz]."""

DAMPING = 0.01
"""Usual damping ratio of the swing [1]: in a window, none at all is out of the noise."""

POINTS = 11, 11, 17
"""Hypotheses of frequency, length and middle that are looked at first."""

NUDGES = np.array([1e-4, 1e-4, 1e-6])
"""What these are moved by to see what it does to the residuals."""

SEARCH = Stopping(evaluations=25, decrement=1e-3, share=0.0)
"""From the best of them to the least residuals: a last step gains a thousandth of a square."""

SPAN = 4.0
"""How many standard deviations about that the hypotheses that count are laid [1]."""

AROUND = 9
"""How many they are along each axis."""

STEP = 1e-3
"""Step that the place of rest is followed with, and the shortest push [s]."""

CLOSE = 0.02
"""Least height of a cable that is reckoned with [m]."""

PARTS = 6
"""Steady parts that stand for half a sine: what it moves is then right to a thousandth."""

SHAPES = np.ones(1), np.pi / 2 * np.sin(np.pi * (np.arange(PARTS) + 0.5) / PARTS)
"""A push's force in equal parts of its length, over its mean: steady, and half a sine."""

NEARLY = 0.99
"""Share of the most likelihood within a frame that counts as the most."""

SHAPE = 0.05
"""What the begin isn't known by, over the length [1]: a push's shape is neither."""


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
class _Grid:
    """Hypotheses of a push of one shape that count."""

    begins: Float64[np.ndarray, "pitches centres lengths"]
    """When the push begins [s]."""
    lengths: Float64[np.ndarray, "pitches centres lengths"]
    """How long it lasts [s]."""
    costs: Float64[np.ndarray, "pitches centres lengths"]
    """Squares of what the frames and the usual length leave, in units of the noise."""
    cell: float
    """Size of the cell that each hypothesis stands for."""


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
    low = np.array([math.log(PITCHES[0]), math.log(STEP), max(moved.before - EARLY, earliest)])
    high = np.array([math.log(PITCHES[1]), math.log(longest), moved.after + longest / 2])
    grids = [_closed_in(window, shape, low, high) for shape in SHAPES]
    least = min(float(grid.costs.min()) for grid in grids)
    scale = _scale(window, least)
    share = np.stack([g.cell * np.exp((least - g.costs) / (2 * scale)) for g in grids])
    begins = np.stack([grid.begins for grid in grids])
    begin = _likeliest(begins, share, within=float(np.median(np.diff(window.time))))
    length, length_sigma = _moments(np.stack([grid.lengths for grid in grids]), share)
    begin_sigma = math.hypot(_moments(begins, share)[1], SHAPE * length)
    return Push(begin, begin_sigma, length, length_sigma)


def _likeliest(
    begins: Float64[np.ndarray, "..."], share: Float64[np.ndarray, "..."], *, within: float
) -> float:
    """The begin that most of the likelihood is within a frame of.

    Shapes that the frames can't tell apart have begins of their own. A mean would lie between
    them, where none has it.
    """
    mean, spread = _moments(begins, share)
    tried = mean + np.linspace(-2, 2, 41) * spread
    near = [float(np.sum(share[np.abs(begins - begin) < within])) for begin in tried]
    most = np.flatnonzero(np.array(near) > NEARLY * max(near))
    return float(np.mean(tried[most]))


def _scale(window: _Window, least: float) -> float:
    """Variance over the noise's: where the best leaves more, its residuals are the measure."""
    return max(least / max(len(window.time) - 5, 1), 1.0)


def _closed_in(
    window: _Window,
    shape: Float64[np.ndarray, " parts"],
    low: Float64[np.ndarray, "3"],
    high: Float64[np.ndarray, "3"],
) -> _Grid:
    """The best push of one shape, and the hypotheses about it.

    They lie along the axes in which the residuals tell them apart: where frames are many, the
    likelihood is a ridge that no grid along the numbers themselves would meet.
    """
    axes = [np.linspace(a, b, n) for a, b, n in zip(low, high, POINTS, strict=True)]
    lengths, centres = np.meshgrid(axes[1], axes[2])
    costs = np.stack(
        [_costs(window, shape, float(pitch), lengths, centres) for pitch in axes[0]]
    )
    row = np.unravel_index(int(costs.argmin()), costs.shape)
    first = np.array([axes[0][row[0]], axes[1][row[2]], axes[2][row[1]]])
    found = minimise(
        lambda point: _misfit(window, shape, point, high), first, stopping=SEARCH, lower=low
    )
    best, misfit = np.minimum(found.point, high), found.normal
    # What the frames don't tell is left to the ranges.
    known = misfit.matrix / _scale(window, misfit.cost) + np.diag((2 / (high - low)) ** 2)
    root = np.linalg.cholesky(np.linalg.inv(known))
    along = np.linspace(-SPAN, SPAN, AROUND)
    unit = np.stack(np.meshgrid(along, along, along, indexing="ij"), axis=-1)[..., [0, 2, 1]]
    pitches, lengths, centres = laid = np.moveaxis(best + unit @ root.T, -1, 0)
    # The first axis alone moves the frequency: `root` is a triangle.
    costs = np.stack(
        [
            _costs(window, shape, float(pitch[0, 0]), length, centre)
            for pitch, length, centre in zip(pitches, lengths, centres, strict=True)
        ]
    )
    outside = [(n < a) | (n > b) for n, a, b in zip(laid, low, high, strict=True)]
    costs[np.any(outside, axis=0)] = np.inf
    lasting = np.exp(lengths)
    return _Grid(centres - lasting / 2, lasting, costs, float(np.linalg.det(root)))


def _misfit(
    window: _Window,
    shape: Float64[np.ndarray, " parts"],
    point: Float64[np.ndarray, "3"],
    high: Float64[np.ndarray, "3"],
) -> SumOfSquares:
    """What a hypothesis leaves; its derivatives are from below, as there is no above."""

    def left(point: Float64[np.ndarray, "3"]) -> Float64[np.ndarray, " rows"]:
        pitch, length, centre = np.minimum(point, high)
        lengths, centres = np.full((1, 1), length), np.full((1, 1), centre)
        return _residuals(window, shape, float(pitch), lengths, centres)[0, 0]

    residuals = left(point)
    nudged = [left(point - nudge) for nudge in np.diag(NUDGES)]
    return SumOfSquares(residuals, (residuals[:, None] - np.stack(nudged, axis=-1)) / NUDGES)


def _window(record: Record, rig: Rig, moved: Onset, length: float) -> _Window | None:
    """The frames from the rest before to the end of the first swing."""
    seen = np.isfinite(record.position[:, X])
    stamps = record.frame_time - record.offset
    frame = float(np.median(np.diff(stamps)))
    seen &= (stamps <= moved.after + max(FRAMES * frame, length)) & (
        stamps > moved.after - REST
    )
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


def _residuals(
    window: _Window,
    shape: Float64[np.ndarray, " parts"],
    pitch: float,
    lengths: Float64[np.ndarray, "centres lengths"],
    centres: Float64[np.ndarray, "centres lengths"],
) -> Float64[np.ndarray, "centres lengths rows"]:
    """What the best place and the best force leave of hypotheses of one frequency.

    The last row says how unusual the length is.
    """
    signal = _signal(window, pitch)
    answer = _answers(window, shape, pitch, lengths, centres)
    square = np.sum(answer**2, axis=-1)
    force = (answer @ signal) / np.where(square > 0, square, np.inf)
    unusual = (lengths - math.log(USUAL)) / SPREAD
    return np.concatenate([signal - force[..., None] * answer, unusual[..., None]], axis=-1)


def _costs(
    window: _Window,
    shape: Float64[np.ndarray, " parts"],
    pitch: float,
    lengths: Float64[np.ndarray, "centres lengths"],
    centres: Float64[np.ndarray, "centres lengths"],
) -> Float64[np.ndarray, "centres lengths"]:
    """Squares of these."""
    return np.sum(_residuals(window, shape, pitch, lengths, centres) ** 2, axis=-1)


def _signal(window: _Window, pitch: float) -> Float64[np.ndarray, " frames"]:
    """What the push alone has moved, about its mean, in units of the noise."""
    signal = (window.place - _carried(window, 2 * np.pi * math.exp(pitch))) / window.sigma
    return signal - signal.mean()


def _answers(
    window: _Window,
    shape: Float64[np.ndarray, " parts"],
    pitch: float,
    lengths: Float64[np.ndarray, "centres lengths"],
    centres: Float64[np.ndarray, "centres lengths"],
) -> Float64[np.ndarray, "centres lengths frames"]:
    """What a push of each hypothesis moves, about its mean."""
    since = window.time - centres[..., None]
    lasting = np.exp(lengths)[..., None]
    omega = 2 * np.pi * math.exp(pitch)
    answer = np.zeros_like(since)
    # Steady parts that follow each other are steps of the force at their borders.
    borders = np.linspace(-0.5, 0.5, len(shape) + 1)
    for border, step in zip(borders, np.diff(shape, prepend=0.0, append=0.0), strict=True):
        answer += step * _answer(since - border * lasting, omega)
    return answer - answer.mean(axis=-1, keepdims=True)


def _answer(since: Float64[np.ndarray, "..."], omega: float) -> Float64[np.ndarray, "..."]:
    """What a push of 1 m/s^2 that lasts has moved after some time, in 1/omega^2."""
    turned = omega * np.maximum(since, 0.0)
    return 1 - np.exp(-DAMPING * turned) * (np.cos(turned) + DAMPING * np.sin(turned))


def _carried(window: _Window, omega: float) -> Float64[np.ndarray, " frames"]:
    """How far the carriages' own motion has taken the end-effector by each frame [m]."""
    decay = math.exp(-DAMPING * omega * STEP)
    cosine, sine = decay * math.cos(omega * STEP), decay * math.sin(omega * STEP)
    x, v = 0.0, 0.0  # the place, and the speed over omega
    places = np.empty(len(window.grid))
    for step, rest in enumerate(window.pulled):
        away = x - rest
        x, v = rest + away * cosine + v * sine, v * cosine - away * sine
        places[step] = x
    return np.interp(window.time, window.grid + STEP, places)


def _moments(
    number: Float64[np.ndarray, "..."], weight: Float64[np.ndarray, "..."]
) -> tuple[float, float]:
    """Mean and standard deviation."""
    mean = float(np.sum(weight * number) / np.sum(weight))
    return mean, math.sqrt(float(np.sum(weight * (number - mean) ** 2) / np.sum(weight)))
