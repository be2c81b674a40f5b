"""What was found, drawn on the pictures: to see, frame by frame, whether it was right."""

from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float64, UInt8

from identification.vision.pictures.opencv import opencv
from identification.vision.pictures.stream import pictures
from identification.vision.settings.document import Mark, Marker, Vision
from identification.vision.settings.read import spot_name
from identification.vision.spots.marks import mark_places
from identification.vision.tracking import Tracked
from scdpr_jax.numerics.files import whole_file
from scdpr_jax.numerics.progress import SILENT, Progress

_WHOLE, _HIDDEN, _MARK = (80, 255, 80), (0, 140, 255), (255, 200, 0)
_SHIFT = 4
"""Binary digits of a pixel's fractions in OpenCV's drawing."""


def write_overlay(
    path: Path, vision: Vision, folder: Path, tracked: Tracked, *, progress: Progress = SILENT
) -> None:
    """Write the video with what was found drawn on it.

    A marker that counts has a green circle of its size, one that is partly hidden an orange
    one; a mark has a blue one where it is expected.

    Args:
        path: The file, `.mp4`, replaced if it exists.
        vision: What is said of the video.
        folder: Where its files are.
        tracked: What it tells.
        progress: Told how far it is.

    Raises:
        ValueError: If the file isn't called `.mp4`, or can't be written.
    """
    if path.suffix.lower() != ".mp4":
        raise ValueError(f"`--overlay`: got {path.name}, expected a file called .mp4.")
    cv2 = opencv()
    with (
        pictures(folder / vision.video) as video,
        whole_file(path, named_in=path.parent) as scratch,
    ):
        # The writer takes its format from the name.
        named = scratch.with_suffix(".mp4")
        writer = cv2.VideoWriter(
            str(named),
            cv2.VideoWriter_fourcc(*"mp4v"),
            vision.time.frame_rate or video.rate or 30.0,
            (video.width, video.height),
        )
        if not writer.isOpened():
            raise ValueError(f"`--overlay`: {path} can't be written. Choose another place.")
        try:
            for frame in video.frames:
                draw(frame.picture, vision, tracked, frame.number)
                writer.write(frame.picture)
                progress("overlay", frame.number / max(video.count, 1))
            writer.release()
            named.replace(scratch)
        finally:
            named.unlink(missing_ok=True)


def draw(
    picture: UInt8[np.ndarray, "height width 3"], vision: Vision, tracked: Tracked, frame: int
) -> None:
    """Draw what was found on a picture.

    Args:
        picture: The picture, drawn on.
        vision: What is said of the video.
        tracked: What it tells.
        frame: Which picture it is.
    """
    cv2 = opencv()
    view, shake = tracked.marks.view, tracked.shake[frame]
    for mark, place in zip(vision.marks, mark_places(vision), strict=True):
        centre = view.pixels(place) + shake
        _circle(cv2, picture, centre, _radius(tracked, mark, place), _MARK)
    for k, marker in enumerate(vision.markers):
        centre = tracked.pixels[frame, k]
        if not np.isfinite(centre[0]):
            continue
        counts = bool(np.isfinite(tracked.poses.places[frame, k, 0]))
        place = np.array([*view.places(centre, marker.depth), marker.depth])
        colour = _WHOLE if counts else _HIDDEN
        _circle(cv2, picture, centre, _radius(tracked, marker, place), colour)
        label = spot_name(vision, marker) + ("" if counts else ", not used")
        _text(cv2, picture, label, centre + np.array([18.0, -14.0]), colour)
    for line, words in enumerate(_words(tracked, frame)):
        _text(cv2, picture, words, np.array([16.0, 32.0 + 26 * line]), (255, 255, 255))


def _words(tracked: Tracked, frame: int) -> list[str]:
    head = f"{frame}   t {tracked.clock.frames[frame]:.4f} s"
    if tracked.doubled[frame]:
        head += "   doubled"
    cells = []
    for name, values in tracked.poses.values.items():
        unit = "mrad" if name == "delta_e" else "mm"
        value = values[frame]
        cells.append(f"{name} {1e3 * value:.2f} {unit}" if np.isfinite(value) else f"{name} -")
    return [head, "   ".join(cells)]


def _radius(tracked: Tracked, spot: Mark | Marker, place: Float64[np.ndarray, " 3"]) -> float:
    return tracked.start.shape(spot, place).radius


def _circle(
    cv2: Any,
    picture: UInt8[np.ndarray, "height width 3"],
    centre: Float64[np.ndarray, " 2"],
    radius: float,
    colour: tuple[int, int, int],
) -> None:
    scale = 1 << _SHIFT
    at = tuple(round(x * scale) for x in centre)
    cv2.circle(picture, at, int(radius * scale), colour, 1, cv2.LINE_AA, _SHIFT)
    for arm in np.array([[3.0, 0.0], [0.0, 3.0]]):
        first, last = (
            tuple(round(x * scale) for x in end) for end in (centre - arm, centre + arm)
        )
        cv2.line(picture, first, last, colour, 1, cv2.LINE_AA, _SHIFT)


def _text(
    cv2: Any,
    picture: UInt8[np.ndarray, "height width 3"],
    words: str,
    at: Float64[np.ndarray, " 2"],
    colour: tuple[int, int, int],
) -> None:
    place = (int(at[0]), int(at[1]))
    font = cv2.FONT_HERSHEY_SIMPLEX
    shadow = (place[0] + 1, place[1] + 1)
    cv2.putText(picture, words, shadow, font, 0.6, (0, 0, 0), 1, cv2.LINE_AA)
    cv2.putText(picture, words, place, font, 0.6, colour, 1, cv2.LINE_AA)
