"""From a video to poses."""

import dataclasses
import glob
import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float64

from identification.vision.lens import Adjusted, Lens, Marks, adjusted, calibrate, fit_plane
from identification.vision.pictures.stream import Video, pictures
from identification.vision.poses import OF_BODY, Poses, poses_of, whole_markers
from identification.vision.settings.document import Vision
from identification.vision.settings.read import spot_name
from identification.vision.spots.bodies import of_bodies
from identification.vision.spots.follow import Follower, Seen
from identification.vision.spots.look import MOST_HIDDEN
from identification.vision.spots.marks import (
    Start,
    colour_magnification,
    first_view,
    mark_places,
    mark_radii,
    require_fit,
)
from identification.vision.timing.clock import Clock, doubled, dropped, read_clock, read_stamps
from identification.vision.timing.tripod import mean_marks, shake_of
from identification.vision.uncertainty import Sigma, sigma_of
from scdpr_jax.numerics.progress import SILENT, Progress

_LENS_SHARE = 0.05
_LEAST_MARKS = 4
_MOST_PHOTOS = 500


@dataclasses.dataclass(frozen=True)
class Tracked:
    """What a video tells."""

    clock: Clock
    """When its pictures were taken."""
    poses: Poses
    """What the bodies did."""
    marks: Marks
    """The marks' plane."""
    sigma: Sigma
    """How far the poses may be off."""
    start: Start
    """What the first picture with enough marks told."""
    mark_pixels: Float64[np.ndarray, "frames marks 2"]
    """Where the marks were seen; NaN where they weren't whole [px]."""
    pixels: Float64[np.ndarray, "frames markers 2"]
    """Where the markers were seen, hidden ones too; NaN where nothing was [px]."""
    shake: Float64[np.ndarray, "frames 2"]
    """How far each picture was shifted [px]."""
    doubled: Bool[np.ndarray, " frames"]
    """Which pictures are the one before once more."""
    columns: tuple[str, ...]
    """Columns of the bodies that have markers."""
    dropped: int
    """Pictures that were dropped, by the stamps."""
    warnings: tuple[str, ...]
    """What should be known of them."""

    @property
    def posed(self) -> int:
        """Pictures in which every body that has markers has a pose."""
        wanted = np.array([self.poses.values[name] for name in self.columns])
        return int(np.isfinite(wanted).all(axis=0).sum())


def track(vision: Vision, folder: Path, *, progress: Progress = SILENT) -> Tracked:
    """Poses from a video.

    Args:
        vision: What is said of it.
        folder: Where its files are.
        progress: Told how far it is.

    Returns:
        What it tells.

    Raises:
        ValueError: If the video, the photos or the marks can't be used.
    """
    with pictures(folder / vision.video) as video:
        size = (video.width, video.height)
        lens, notes = lens_of(vision, folder, size, progress.part(0.0, _LENS_SHARE))
        read = _read(vision, folder, lens, video, progress.part(_LENS_SHARE, 1.0))
    return _put_together(vision, folder, lens, read, notes)


def lens_of(
    vision: Vision, folder: Path, size: tuple[int, int], progress: Progress = SILENT
) -> tuple[Lens, tuple[str, ...]]:
    """The lens of a video: as it is stated, or from photos of a board.

    Args:
        vision: What is said of the video.
        folder: Where its files are.
        size: Width and height of its pictures [px].
        progress: Told how far it is.

    Returns:
        The lens, and what should be known of it.
    """
    told = vision.calibration
    if told.matrix is not None:
        distortion = np.array([*told.distortion, *[0.0] * (5 - len(told.distortion))])
        return Lens(np.array(told.matrix), distortion), ()
    patterns = [told.photos] if isinstance(told.photos, str) else told.photos
    photos = [Path(p) for each in patterns for p in _files(folder, each)]
    if not photos:
        raise ValueError(
            f"calibration: no photos, got none that are called {', '.join(patterns)} in "
            f"{folder}. Check the key `photos`."
        )
    return calibrate(
        photos,
        inner_corners=told.inner_corners,
        square=told.square,
        size=size,
        progress=progress,
    )


def _files(folder: Path, pattern: str) -> list[str]:
    """Files of a pattern, as many as photos of a board can be."""
    whole = str(folder / pattern)
    found = list(itertools.islice(glob.iglob(whole), _MOST_PHOTOS + 1))
    if len(found) > _MOST_PHOTOS:
        raise ValueError(
            f"calibration: more than {_MOST_PHOTOS} photos are called {pattern}, expected "
            "some twenty. Correct the key `photos`."
        )
    return sorted(found)


@dataclasses.dataclass(frozen=True)
class _Read:
    """What was seen in every picture."""

    start: Start
    marks: list[Seen]
    markers: list[Seen]
    change: Float64[np.ndarray, " frames"]
    stored: Float64[np.ndarray, " frames"]
    count: int
    height: int


def _read(vision: Vision, folder: Path, lens: Lens, video: Video, progress: Progress) -> _Read:
    marks, markers, change, stored = [], [], [], []
    follower, blank = None, 0
    stamps = {} if vision.time.stamps is None else read_stamps(folder / vision.time.stamps)
    rate = vision.time.frame_rate or video.rate or 30.0
    for frame in video.frames:
        if follower is None:
            start = first_view(vision, lens, frame.picture)
            if start is not None:
                follower = Follower(vision, start)
        change.append(frame.change)
        stored.append(frame.time)
        if follower is None:
            blank += 1
            continue
        marks.append(follower.marks(frame))
        markers.append(follower.markers(frame, stamps.get(frame.number, frame.number / rate)))
        if frame.number % 8 == 0:
            progress(f"picture {frame.number}", frame.number / max(video.count, 1))
    if follower is None:
        raise ValueError(
            f"marks: fewer than {_LEAST_MARKS} were found whole in any of {blank} pictures. "
            "See whether `near` points at them, whether their colours are described as they "
            "look, and whether `diameter` is theirs."
        )
    nothing = [_nothing(len(vision.marks))] * blank, [_nothing(len(vision.markers))] * blank
    return _Read(
        follower.start,
        [*nothing[0], *marks],
        [*nothing[1], *markers],
        np.array(change),
        np.array(stored),
        video.count,
        video.height,
    )


def _nothing(count: int) -> Seen:
    missing = np.full(count, np.nan)
    places = np.full((count, 2), np.nan)
    return Seen(places, missing, missing, missing, places)


def _put_together(
    vision: Vision, folder: Path, lens: Lens, read: _Read, notes: tuple[str, ...]
) -> Tracked:
    count = len(read.change)
    clock = read_clock(vision.time, folder, count=count, height=read.height)
    mark_pixels = _whole_marks(read.marks)
    pixels = np.array([each.pixel for each in read.markers])
    again = doubled(read.change, pixels)
    shake = shake_of(mark_pixels, clock, ~again & np.isfinite(mark_pixels[..., 0]).any(axis=1))
    steady = shake.without(mark_pixels, clock)[~again]
    mean = _without_colour(vision, lens, mean_marks(steady))
    fit = _plane(vision, lens, mean)
    whole = whole_markers(
        pixels,
        np.array([each.scale for each in read.markers]),
        np.array([each.hidden for each in read.markers]),
        most_hidden=MOST_HIDDEN,
    )
    counts = whole & ~again[:, None] & np.isfinite(clock.frames)[:, None]
    variance = np.array([each.variance for each in read.markers])
    poses = poses_of(vision, fit.marks.view, clock, pixels, counts, shake)
    after = clock.offset(np.where(counts, pixels[..., 1], np.nan))
    return Tracked(
        clock,
        poses,
        fit.marks,
        sigma_of(vision, fit, poses, variance, shake.error(after)),
        read.start,
        mark_pixels,
        pixels,
        shake.filled,
        again,
        tuple(name for body, _ in of_bodies(vision) for name in OF_BODY[body]),
        dropped(clock.frames if vision.time.stamps else read.stored),
        (*notes, *_warnings(vision, read, clock, shake.filled)),
    )


def _whole_marks(seen: list[Seen]) -> Float64[np.ndarray, "frames marks 2"]:
    pixels = np.array([each.pixel for each in seen])
    hidden = np.array([each.hidden for each in seen])
    return np.where((hidden < MOST_HIDDEN)[..., None], pixels, np.nan)


def _without_colour(
    vision: Vision, lens: Lens, pixels: Float64[np.ndarray, "marks 2"]
) -> Float64[np.ndarray, "marks 2"]:
    """The marks as grey light would have them."""
    return np.array(
        [
            lens.without_colour(pixel, colour_magnification(vision, mark, lens.lateral))
            for pixel, mark in zip(pixels, vision.marks, strict=True)
        ]
    )


def _plane(vision: Vision, lens: Lens, pixels: Float64[np.ndarray, "marks 2"]) -> Adjusted:
    kept = np.flatnonzero(np.isfinite(pixels[:, 0]))
    places, radii = mark_places(vision)[kept], mark_radii(vision)[kept]
    fit = fit_plane(lens, places, pixels[kept], radii)
    require_fit(vision, fit, kept.tolist())
    return adjusted(fit, places, pixels[kept], radii)


def _warnings(
    vision: Vision, read: _Read, clock: Clock, shake: Float64[np.ndarray, "frames 2"]
) -> Iterator[str]:
    count = len(read.change)
    if count < read.count - 1:
        yield (
            f"the video ends after {count} of the {read.count} pictures that it says it has: "
            "it may be cut off"
        )
    for spots, seen in ((vision.marks, read.marks), (vision.markers, read.markers)):
        found = np.isfinite([each.pixel[:, 0] for each in seen]).any(axis=0)
        for spot, there in zip(spots, found, strict=True):
            if not there:
                yield (
                    f"{spot_name(vision, spot)} wasn't found in any picture: see with "
                    "--overlay whether it is there, and what its colour is called"
                )
    missing = np.count_nonzero(~np.isfinite(clock.frames))
    if missing:
        yield f"{missing} pictures have no stamp and aren't in camera.csv"
    if vision.time.stamps is None:
        lost = dropped(read.stored)
        if lost:
            yield (
                f"by the file's own times about {lost} pictures were dropped, so `frame_rate` "
                "puts those after them too early: give `stamps`"
            )
    if shake.any():
        size = float(np.sqrt((shake**2).sum(axis=1).mean()))
        yield f"the camera shook by {size:.2f} px (rms); taken off by the marks"
