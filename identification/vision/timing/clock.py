"""When each picture was taken, and which of them were dropped or doubled."""

import dataclasses
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float64

from identification.campaign.tables.columns import TIME
from identification.campaign.tables.text_file import read_text
from identification.vision.settings.document import FIRST_STAMP, Time
from scdpr_jax.numerics.files.given import SHORT_TABLE, split_rows
from scdpr_jax.numerics.files.harmless import represented

_CERTAIN = 0.3  # of the change beside it
_NOISY = 1.0  # levels: two pictures of a noisy camera differ by more
_LEVEL = 0.1  # levels: no change is less
_MOST = 0.3  # share of pictures that may be copies
_IN_A_ROW = 4  # pictures: a robot that stops takes longer to go on
_NOTHING = 4.0  # levels: what coding a picture twice may cost
_COPY = 0.5  # levels: a copy that wasn't coded anew
_MOVES = 0.5  # px
_FAST = 2.0  # px
_STAYS = 0.15  # of the steps before and after
_RARE = 0.1  # share of pictures
_FAR = 10.0  # times: a robot that begins to move passes all changes between
_GAP = 1.5  # usual intervals


@dataclasses.dataclass(frozen=True)
class Clock:
    """Times of a video's pictures and rows."""

    frames: Float64[np.ndarray, " frames"]
    """Middle of the exposure of the sensor's middle row [s]; NaN where there is no stamp."""
    row_time: float
    """Time from a row of the stored picture to the one below [s]."""
    middle_row: float
    """The row that is exposed at the picture's time [px]."""

    def offset(self, row: Float64[np.ndarray, "*many"]) -> Float64[np.ndarray, "*many"]:
        """How much later than the picture's time a row is exposed.

        Args:
            row: The row [px].

        Returns:
            The difference [s].
        """
        return (row - self.middle_row) * self.row_time


def read_clock(time: Time, folder: Path, *, count: int, height: int) -> Clock:
    """The clock of a video.

    Args:
        time: What is said of it.
        folder: Where its file of stamps is.
        count: Number of stored pictures.
        height: Rows of a picture.

    Returns:
        The clock.

    Raises:
        ValueError: If the stamps can't be used.
    """
    if time.stamps is None:
        frames = time.first_frame + np.arange(count) / time.frame_rate
    else:
        stamps = read_stamps(folder / time.stamps)
        frames = np.array([stamps.get(k, np.nan) for k in range(count)])
        if np.count_nonzero(np.isfinite(frames)) < 2:
            raise ValueError(
                f"stamps: {time.stamps} has no stamps of these {count} pictures. Frames count "
                "from 0."
            )
    if time.stamp_at == FIRST_STAMP:
        frames = frames + (time.exposure + time.readout) / 2
    row_time = time.readout / max(height - 1, 1)
    if time.readout_direction == "up":
        row_time = -row_time
    return Clock(frames, row_time, (height - 1) / 2)


def read_stamps(path: Path) -> dict[int, float]:
    """Stamps of pictures.

    Args:
        path: CSV file with `frame`, from 0, and `t` with its unit.

    Returns:
        Their times by their places [s].

    Raises:
        ValueError: If there are none in it.
    """
    text, fault = read_text(path, most=SHORT_TABLE)
    if fault is not None:
        raise ValueError(f"stamps: {dataclasses.replace(fault, file=str(path))}")
    rows = split_rows(path, text)
    header = [cell.strip() for cell in rows[0][1]] if rows else []
    units = {f"t [{unit}]": scale for unit, scale in TIME.items()}
    column = next((cell for cell in header if cell in units), None)
    if column is None or "frame" not in header:
        raise ValueError(
            f"stamps: {path.name}: got the columns "
            f"{represented(', '.join(header)) if header else 'none'}, expected "
            "`frame` and `t [s]`. Name them so; frames count from 0."
        )
    stamps = {}
    for number, row in rows[1:]:
        if not any(cell.strip() for cell in row):
            continue
        try:
            frame = int(row[header.index("frame")])
            stamp = float(row[header.index(column)])
        except (ValueError, IndexError):
            raise ValueError(
                f"stamps: {path.name}, row {number}: got {represented(','.join(row))}, "
                f"expected a whole number of a frame and a time {column[1:].strip()}. "
                "Correct the row."
            ) from None
        stamps[frame] = float(units[column](np.array([stamp]))[0])
    return stamps


def dropped(times: Float64[np.ndarray, " frames"]) -> int:
    """How many pictures were dropped, by gaps between stamps.

    Args:
        times: Times of the pictures [s].

    Returns:
        Their number.
    """
    steps = np.diff(times[np.isfinite(times)])
    steps = steps[steps > 0]
    if len(steps) < 2:
        return 0
    usual = np.median(steps)
    return int(np.round(steps[steps > _GAP * usual] / usual - 1).sum())


def doubled(
    change: Float64[np.ndarray, " frames"], pixels: Float64[np.ndarray, "frames markers 2"]
) -> Bool[np.ndarray, " frames"]:
    """Which pictures are the one before once more.

    Noise makes any two pictures differ, and a picture that is stored twice hardly does: among
    the largest differences of a block, those of doubled pictures stand apart at the low end.
    Where a codec has taken the noise away, still pictures look alike, too. There a picture is
    doubled if all that moves before and after it has stayed where it was.

    Args:
        change: Largest mean difference of a block from the picture before [levels].
        pixels: Where the markers are seen; NaN where they aren't [px].

    Returns:
        Whether each is.
    """
    certain = change <= _apart(change[1:])
    stays = np.zeros(len(change), bool)
    for first, last in _quiet_runs(change):
        around = min(change[first - 1], change[last + 1])
        less = change[first : last + 1].max() < _CERTAIN * around
        if less and _stayed(pixels[[first - 2, first - 1, last, last + 1]]):
            stays[first : last + 1] = True
    found = certain | stays
    found[:1] = False
    return found


def _quiet_runs(change: Float64[np.ndarray, " frames"]) -> Iterator[tuple[int, int]]:
    """First and last of some pictures in a row in which hardly anything changes."""
    quiet = np.concatenate([[False], change < _NOTHING, [False]])
    edges = np.flatnonzero(np.diff(quiet.astype(int)))
    for first, after in edges.reshape(-1, 2).tolist():
        if first >= 2 and after < len(change) and after - first <= _IN_A_ROW:
            yield first, after - 1


def _stayed(pixels: Float64[np.ndarray, "4 markers 2"]) -> bool:
    """Whether all that moves before and after some pictures stays where it is in them.

    Which way it goes on isn't asked: where a vibration turns, a copy is as wrong.
    """
    before, now, after = (np.hypot(*step.T) for step in np.diff(pixels, axis=0))
    length = np.minimum(before, after)
    moving = (length > _MOVES) & (np.maximum(before, after) > _FAST)
    still = now < _STAYS * np.maximum(before, after)
    return bool(moving.any() and still[moving].all())


def _apart(change: Float64[np.ndarray, " pairs"]) -> float:
    """The largest change of those that stand apart at the low end; negative if none do.

    Copies that were coded anew differ by as much as still pictures do. They are told by this
    only where nothing is still, as by a lamp that flickers or a tripod that shakes.
    """
    ordered = np.sort(change)
    few = ordered[: max(2, int(_MOST * len(ordered)))]
    if len(few) < 2:
        return -1.0
    ratios = (few[1:] + _LEVEL) / (few[:-1] + _LEVEL)
    coded = few[:-1] > _COPY
    rare = np.arange(1, len(few)) <= _RARE * len(ordered)
    ratios[coded & ~(rare & (ratios > _FAR))] = 0.0
    gap = int(np.argmax(ratios))
    stands_apart = ratios[gap] * _CERTAIN > 1 and few[gap + 1] > _NOISY
    return float(few[gap]) if stands_apart else -1.0
