"""The lens from photos of a chessboard."""

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float32, Float64, UInt8

from identification.vision.lens.lateral import blue_less_red
from identification.vision.lens.lens import Lens
from identification.vision.pictures.opencv import opencv
from identification.vision.pictures.photos import read_photos
from scdpr_jax.numerics.progress import SILENT, Progress

MOST_RMS = 0.3
"""A board's corners that lie further about the fit than this are no calibration [px]."""
_LEAST_PHOTOS = 5
_SMALL = 1000
_SIGNIFICANT = 3.0
_STRANGE = 5.0  # times what corners are off by in the others
_OF_STRANGERS = 5  # photos, of which one may be strange


def calibrate(
    photos: Sequence[Path],
    *,
    inner_corners: tuple[int, int],
    square: float,
    size: tuple[int, int],
    progress: Progress = SILENT,
) -> tuple[Lens, tuple[str, ...]]:
    """Fit a lens to photos of a chessboard, made as the video was.

    The radial term k3 is taken only where the photos tell it: at a picture's edge, where no
    board was, a term that was fitted to noise bends everything.

    Args:
        photos: The photos.
        inner_corners: Corners between squares in a row, and rows of them.
        square: Side of a square [m].
        size: Width and height of the video's pictures [px].
        progress: Told how far it is.

    Returns:
        The lens, and what should be known of the photos that weren't used.

    Raises:
        ValueError: If the photos have another size, too few show the board, or the corners
            are further from the fit than 0.3 px.
    """
    found, colours = [], []
    for number, (photo, picture) in enumerate(zip(photos, read_photos(photos), strict=True)):
        progress(f"board {photo.name}", number / len(photos))
        _check_size(photo, picture, size)
        corners = _corners(_grey(picture), inner_corners)
        found.append(corners)
        if corners is not None:
            colours.append(blue_less_red(picture, corners, np.array(size) / 2))
    without = [photo.name for photo, each in zip(photos, found, strict=True) if each is None]
    seen = [k for k, each in enumerate(found) if each is not None]
    corners = [found[k] for k in seen]
    across, down = inner_corners
    if len(corners) < _LEAST_PHOTOS:
        raise ValueError(
            f"calibration: {len(corners)} of {len(photos)} photos show a board of {across} x "
            f"{down} inner corners, expected at least {_LEAST_PHOTOS}. Count the corners "
            "between four squares, not the squares, and correct `inner_corners`; or take "
            "photos with the whole board in them, sharp, and a white rim around it."
        )
    strange = _strangers(corners, inner_corners, square, size)
    corners = [each for k, each in enumerate(corners) if k not in strange]
    lens = _fitted(corners, inner_corners, square, size)
    if lens.rms > MOST_RMS:
        raise ValueError(
            f"calibration: corners are {lens.rms:.2f} px from the fit (rms), expected at most "
            f"{MOST_RMS} px. Is the board flat, are the photos sharp, and were they taken with "
            "the focus and zoom of the video? Leave out the blurred ones."
        )
    lens = dataclasses.replace(lens, lateral=float(np.median(colours)))
    notes = []
    if without:
        notes.append(f"no board of {across} x {down} corners in {', '.join(without)}: not used")
    if strange:
        names = ", ".join(photos[seen[k]].name for k in strange)
        notes.append(f"corners that aren't where the others have them in {names}: not used")
    return lens, tuple(notes)


def _check_size(
    photo: Path, picture: UInt8[np.ndarray, "height width 3"], size: tuple[int, int]
) -> None:
    height, width = picture.shape[:2]
    if (width, height) != size:
        raise ValueError(
            f"calibration: {photo.name} has {width} x {height} px, expected {size[0]} x "
            f"{size[1]} as the video. Take the photos in the video's mode: another size is "
            "another part of the sensor, and another lens to this programme."
        )


def _grey(picture: UInt8[np.ndarray, "height width 3"]) -> UInt8[np.ndarray, "height width"]:
    cv2 = opencv()
    return cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)


def _corners(
    grey: UInt8[np.ndarray, "height width"], inner_corners: tuple[int, int]
) -> Float32[np.ndarray, "corners 1 2"] | None:
    """The board's inner corners, to a few hundredths of a pixel; None if it isn't there."""
    cv2 = opencv()
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
    # What is no board takes long to be told in a large picture.
    share = min(1.0, _SMALL / max(grey.shape))
    small = cv2.resize(grey, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    found, corners = cv2.findChessboardCorners(small, inner_corners, flags=flags)
    if not found:
        return None
    corners = ((corners + 0.5) / share - 0.5).astype(np.float32)
    grid = corners.reshape(inner_corners[1], inner_corners[0], 2)
    least = min(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min() for axis in (0, 1))
    half = max(3, int(0.3 * least))
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-4)
    # OpenCV 5 takes and gives a list of points, 4 a column of them.
    corners = corners.reshape(-1, 1, 2)
    fine = cv2.cornerSubPix(grey, corners, (half, half), (-1, -1), criteria)
    return np.asarray(fine, np.float32).reshape(-1, 1, 2)


def _strangers(
    corners: Sequence[Float32[np.ndarray, "corners 1 2"]],
    inner_corners: tuple[int, int],
    square: float,
    size: tuple[int, int],
) -> list[int]:
    """A few photos of many in which corners were taken for others.

    At the picture's edge a square is cut off, and OpenCV takes its neighbour's corner.
    """
    strange: list[int] = []
    for _ in range(min(len(corners) // _OF_STRANGERS, len(corners) - _LEAST_PHOTOS)):
        kept = [k for k in range(len(corners)) if k not in strange]
        boards = [_board(inner_corners, square)] * len(kept)
        views = [corners[k] for k in kept]
        result = opencv().calibrateCameraExtended(boards, views, size, None, None)
        errors = np.ravel(result[7])
        stands_out = errors.max() > max(MOST_RMS, _STRANGE * float(np.median(errors)))
        if result[0] <= MOST_RMS and not stands_out:
            break
        strange.append(kept[int(np.argmax(errors))])
    return strange


def _board(inner_corners: tuple[int, int], square: float) -> Float32[np.ndarray, "corners 3"]:
    across, down = inner_corners
    board = np.zeros((across * down, 3), np.float32)
    board[:, :2] = square * np.mgrid[:across, :down].T.reshape(-1, 2)
    return board


def _fitted(
    corners: Sequence[Float32[np.ndarray, "corners 1 2"]],
    inner_corners: tuple[int, int],
    square: float,
    size: tuple[int, int],
) -> Lens:
    cv2 = opencv()
    boards = [_board(inner_corners, square)] * len(corners)
    result = cv2.calibrateCameraExtended(boards, corners, size, None, None)
    k3, error = np.ravel(result[2])[4], np.ravel(result[5])[8]
    flags = 0 if abs(k3) > _SIGNIFICANT * error else cv2.CALIB_FIX_K3
    rms, lens = _fit(boards, corners, size, flags)
    others = [
        _fit(boards[1:], [*corners[:k], *corners[k + 1 :]], size, flags)[1]
        for k in range(len(corners))
    ]
    return Lens(*_parts(lens), rms, _deviations(np.array(others)))


def _fit(
    boards: Sequence[Float32[np.ndarray, "corners 3"]],
    corners: Sequence[Float32[np.ndarray, "corners 1 2"]],
    size: tuple[int, int],
    flags: int,
) -> tuple[float, Float64[np.ndarray, " 9"]]:
    """The rms [px], and fx, fy, cx, cy and the distortion."""
    rms, matrix, distortion = opencv().calibrateCamera(
        boards, corners, size, None, None, flags=flags
    )[:3]
    inner = np.asarray(matrix, float)[[0, 1, 0, 1], [0, 1, 2, 2]]
    return float(rms), np.concatenate([inner, np.ravel(distortion)[:5]])


def _parts(
    numbers: Float64[np.ndarray, " 9"],
) -> tuple[Float64[np.ndarray, "3 3"], Float64[np.ndarray, " 5"]]:
    fx, fy, cx, cy = numbers[:4]
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]]), numbers[4:]


def _deviations(
    others: Float64[np.ndarray, "photos 9"],
) -> Float64[np.ndarray, "photos 9"]:
    """The jackknife: how the lens changes as each photo is left out.

    The fit's own covariance takes a photo's corners for independent. They aren't: light,
    blur and the board's flatness are the same for all of them, and it is two to three times
    too small.
    """
    count = len(others)
    return np.sqrt((count - 1) / count) * (others - others.mean(axis=0))
