r"""A tripod that shakes, by the marks: they stand still, so what they do is the camera's.

Each mark is seen at its own row's time. Its moves are put at the picture's time by the pictures
before and after, and their mean is the picture's shift; from there it is put at a marker's row
likewise. Where the camera shakes at a quarter of the pictures' rate, or a picture is missing,
both are off, the more the farther a row is from the middle one. So a line through what the
marks of each picture still do, by their rows' times, is taken off, too:

$$ p_{mk} - P_m - s_k(o_{mk}) = a_k + d_k (o_{mk} - \bar o_k) + n_{mk} $$

A mark's noise $n$ is what the lines leave, so the variance at a row is
$\sigma^2 / M + w \sigma^2 (o - \bar o)^2 / \sum (o_m - \bar o)^2$. Slopes are noise where rows
are close to each other, so they count by the share $w$ of their squares that isn't. How far the
marks move after all would tell less: it is mostly each mark's own noise.
"""

import dataclasses

import numpy as np
from jaxtyping import Bool, Float64

from identification.vision.timing.clock import Clock
from identification.vision.timing.shutter import at_frame_times

_SIGNIFICANT = 4.0
_LEAST = 3
_ROUNDS = 3
_LINE = 2  # numbers of a line


@dataclasses.dataclass(frozen=True)
class Shake:
    """How far the pictures are shifted, at any of their rows."""

    shift: Float64[np.ndarray, "frames 2"]
    """At each picture's time, by all marks; NaN where too few are seen, zeros if it is none
    [px]."""
    pivot: Float64[np.ndarray, " frames"]
    """Mean time of the marks' rows after the picture's [s]."""
    rest: Float64[np.ndarray, "frames 2"]
    """What is added at that time [px]."""
    drift: Float64[np.ndarray, "frames 2"]
    """What is added to it with each second after [px/s]."""
    rest_variance: Float64[np.ndarray, "frames 2"]
    """Of shift and `rest` together [px²]."""
    drift_variance: Float64[np.ndarray, "frames 2"]
    """Of `drift` [px²/s²]."""

    @property
    def filled(self) -> Float64[np.ndarray, "frames 2"]:
        """Shifts at the pictures' times, those between where they aren't known [px]."""
        return _filled(self.shift)

    def at(
        self,
        times: Float64[np.ndarray, " frames"],
        wanted: Float64[np.ndarray, " frames"],
    ) -> Float64[np.ndarray, "frames 2"]:
        """The shift at a marker's own row.

        Args:
            times: The pictures' times [s].
            wanted: The row's times [s].

        Returns:
            The shift then [px].
        """
        # A picture without a stamp has no rows' times either.
        after = np.nan_to_num(wanted - times - self.pivot)[:, None]
        return _between(self.shift, times, wanted) + self.rest + self.drift * after

    def without(
        self, pixels: Float64[np.ndarray, "frames spots 2"], clock: Clock
    ) -> Float64[np.ndarray, "frames spots 2"]:
        """Where spots would be seen by a steady camera.

        Args:
            pixels: Where they are seen; NaN where they aren't [px].
            clock: When which row is exposed.

        Returns:
            The same without the shift at each one's own row [px].
        """
        wanted = clock.frames[:, None] + clock.offset(pixels[..., 1])
        shifts = [self.at(clock.frames, own) for own in wanted.T]
        return pixels - np.stack(shifts, axis=1)

    def error(
        self, after: Float64[np.ndarray, "frames markers"]
    ) -> Float64[np.ndarray, "2 markers"]:
        """How far the shift at markers' rows is off, root mean square.

        Args:
            after: How much later than the pictures' times the rows are exposed; NaN where a
                marker isn't seen [s].

        Returns:
            Standard deviation along each direction, zeros without a shake or a marker [px].
        """
        squares = (after - self.pivot[:, None]) ** 2
        seen = np.isfinite(squares)
        variance = self.rest_variance[:, :, None] + self.drift_variance[
            :, :, None
        ] * np.nan_to_num(squares[:, None])
        counts = np.maximum(seen.sum(axis=0), 1)
        return np.sqrt((variance * seen[:, None]).sum(axis=0) / counts)


def mean_marks(
    steady: Float64[np.ndarray, "frames marks 2"],
) -> Float64[np.ndarray, "marks 2"]:
    """Where the marks are in the mean.

    Args:
        steady: Where they are seen, the shake taken off; NaN where they aren't [px].

    Returns:
        Means of the middle half; NaN where a mark was never seen [px].
    """
    means = np.full(steady.shape[1:], np.nan)
    for k in range(steady.shape[1]):
        seen = np.sort(steady[np.isfinite(steady[:, k, 0]), k], axis=0)
        if len(seen):
            quarter = len(seen) // 4
            means[k] = seen[quarter : len(seen) - quarter].mean(axis=0)
    return means


def shake_of(
    pixels: Float64[np.ndarray, "frames marks 2"],
    clock: Clock,
    usable: Bool[np.ndarray, " frames"],
) -> Shake:
    """How far each picture is shifted.

    A mark's noise is in it, too, so it is taken for a shake only where the marks move
    together by more than they do each on its own; a steady camera's pictures are left alone.

    Args:
        pixels: Where the marks are seen; NaN where they aren't [px].
        clock: When which row is exposed.
        usable: Pictures that aren't doubled.

    Returns:
        The shift; zeros if it is none.
    """
    still = np.zeros((len(pixels), 2))
    shift = still
    counted = np.where(usable[:, None, None], pixels, np.nan)
    for _ in range(_ROUNDS):
        filled = _filled(shift)
        apart = counted - mean_marks((counted - filled[:, None])[usable])
        together = _means(apart)
        within = np.nanmean((apart - together[:, None]) ** 2)
        count = max(np.isfinite(pixels[..., 0]).sum(axis=1).mean(), 1.0)
        mean = np.nanmean(together[usable], axis=0)
        shared = np.nanmean((together[usable] - mean) ** 2)
        if not shared > _SIGNIFICANT * within / count:
            return Shake(still, still[:, 0], still, still, still, still)
        # Each by its own row's time: the mean of all is that of no time.
        at_frames = [
            at_frame_times(own, clock.frames + clock.offset(rows), clock.frames)
            for own, rows in zip(apart.swapaxes(0, 1), pixels[..., 1].T, strict=True)
        ]
        shift = _means(np.stack(at_frames, axis=1))
    return _by_rows(counted, clock, shift)


def _by_rows(
    pixels: Float64[np.ndarray, "frames marks 2"],
    clock: Clock,
    shift: Float64[np.ndarray, "frames 2"],
) -> Shake:
    """A line through what the marks of each picture still do, by their rows' times."""
    after = clock.offset(pixels[..., 1])
    left = np.full_like(pixels, np.nan)
    for k, own in enumerate(pixels.swapaxes(0, 1)):
        moved = own - _between(shift, clock.frames, clock.frames + after[:, k])
        if np.isfinite(moved[:, 0]).any():
            left[:, k] = moved - np.nanmedian(moved, axis=0)
    seen = np.isfinite(left[..., 0])
    seen &= (seen.sum(axis=1) >= _LEAST)[:, None]
    counts = np.maximum(seen.sum(axis=1), 1)
    pivot = np.where(seen, after, 0.0).sum(axis=1) / counts
    arm = np.where(seen, after - pivot[:, None], 0.0)[..., None]
    left = np.where(seen[..., None], left, 0.0)
    rest = left.sum(axis=1) / counts[:, None]
    inertia = (arm**2).sum(axis=1)
    lever = np.divide(1.0, inertia, out=np.zeros_like(inertia), where=inertia > 0)
    slope = (arm * left).sum(axis=1) * lever
    noise = (left - rest[:, None] - slope[:, None] * arm) * seen[..., None]
    free = np.maximum(seen.sum(axis=1) - _LINE, 0).sum()
    variance = (noise**2).sum(axis=(0, 1)) / max(free, 1)
    known = seen.any(axis=1)[:, None]
    by_noise = variance * lever
    # A sum over pictures, each by how well it tells: of noise alone it is their number.
    squares = (slope**2 * inertia).sum(axis=0)
    chance = variance * np.count_nonzero(lever)
    share = np.clip(1 - chance / np.where(squares > 0, squares, np.inf), 0.0, 1.0)
    share = np.where(squares > 0, share, 0.0)
    return Shake(
        shift,
        pivot,
        rest,
        share * slope,
        np.where(known, variance / counts[:, None], variance),
        share * by_noise,
    )


def _between(
    shift: Float64[np.ndarray, "frames 2"],
    times: Float64[np.ndarray, " frames"],
    wanted: Float64[np.ndarray, " frames"],
) -> Float64[np.ndarray, "frames 2"]:
    """Shifts at a row's time, by those of the pictures before and after [px]."""
    rows = np.where(np.isfinite(wanted), wanted, times)
    return _filled(at_frame_times(shift, times, rows))


def _means(apart: Float64[np.ndarray, "frames marks 2"]) -> Float64[np.ndarray, "frames 2"]:
    """Mean over the marks that are seen; NaN with too few."""
    enough = np.isfinite(apart[..., 0]).sum(axis=1) >= _LEAST
    means = np.full((len(apart), 2), np.nan)
    means[enough] = np.nanmean(apart[enough], axis=1)
    return means


def _filled(shift: Float64[np.ndarray, "frames 2"]) -> Float64[np.ndarray, "frames 2"]:
    """Shifts that aren't known, between those that are."""
    known = np.isfinite(shift[:, 0])
    if not known.any():
        return np.zeros_like(shift)
    places = np.arange(len(shift))
    return np.stack(
        [np.interp(places, places[known], column[known]) for column in shift.T], axis=-1
    )
