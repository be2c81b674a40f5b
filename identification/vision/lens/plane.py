"""Where the camera stands, from the marks."""

import dataclasses

import numpy as np
import scipy.optimize
from jaxtyping import Float64

from identification.vision.lens.lens import Lens
from identification.vision.lens.view import View
from identification.vision.pictures.opencv import opencv

_SCALE = 0.5


@dataclasses.dataclass(frozen=True)
class Marks:
    """The marks' plane as it was fitted."""

    view: View
    """Where the camera stands."""
    residual: Float64[np.ndarray, "marks 2"]
    """Seen less expected, in undistorted pixels [px]."""

    @property
    def rms(self) -> float:
        """Root mean square distance of a mark from where it is expected [px]."""
        return float(np.sqrt((self.residual**2).sum(axis=-1).mean()))


def fit_plane(
    lens: Lens,
    places: Float64[np.ndarray, "marks 3"],
    seen: Float64[np.ndarray, "marks 2"],
    radius: Float64[np.ndarray, " marks"],
    *,
    begin: View | None = None,
) -> Marks:
    r"""The camera's place, by robust least squares in undistorted pixels.

    Six numbers are sought: a rotation vector and a translation. A homography has eight and
    needs no lens, but it doesn't tell how far the plane is, so it can't put a marker that
    stands before the plane in its place. The sum is of $2 s^2 (\sqrt{1 + |e/s|^2} - 1)$ with
    $s$ = 0.5 px: a mark that was measured wrong pulls, but no more than one that is 0.5 px
    off. A view of a plane has a mirrored twin of nearly the same picture; both are fitted,
    and the better one that has the camera before the plane is taken.

    Args:
        lens: The lens.
        places: The marks in the frame's coordinates [m].
        seen: Centroids of their images [px].
        radius: Radius of those that are discs, 0 of others [m].
        begin: A view to begin at, where one is known.

    Returns:
        The fit.
    """
    starts = _starts(lens, places, seen) if begin is None else [pose_of(begin)]
    fits = [_refined(lens, places, seen, radius, start) for start in starts]
    before = [fit for fit in fits if _eye(fit.view)[2] > places[:, 2].max()]
    return min(before or fits, key=lambda fit: fit.rms)


def pose_of(view: View) -> Float64[np.ndarray, " 6"]:
    """Where a camera stands, as six numbers.

    Args:
        view: The camera.

    Returns:
        Rotation vector and translation [rad, m].
    """
    turn = np.asarray(opencv().Rodrigues(view.rotation)[0], float)
    return np.concatenate([turn.ravel(), view.translation])


def view_of(lens: Lens, pose: Float64[np.ndarray, " 6"]) -> View:
    """A camera of a place.

    Args:
        lens: Its lens.
        pose: Rotation vector and translation [rad, m].

    Returns:
        The camera.
    """
    return View(lens, opencv().Rodrigues(pose[:3])[0], pose[3:])


def undistorted(
    view: View,
    places: Float64[np.ndarray, "marks 3"],
    seen: Float64[np.ndarray, "marks 2"],
    radius: Float64[np.ndarray, " marks"],
) -> Float64[np.ndarray, "marks 2"]:
    """How far marks are seen from where a camera has them, without distortion.

    Args:
        view: The camera.
        places: The marks in the frame's coordinates [m].
        seen: Centroids of their images [px].
        radius: Radius of those that are discs, 0 of others [m].

    Returns:
        Seen less expected [px].
    """
    directions = view.lens.directions(seen - _offsets(view, places, radius))
    return _apart(view, places, directions)


def _offsets(
    view: View, places: Float64[np.ndarray, "marks 3"], radius: Float64[np.ndarray, " marks"]
) -> Float64[np.ndarray, "marks 2"]:
    pairs = zip(places, radius, strict=True)
    return np.concatenate([view.centroid_offset(p[None], r or 1e-6) for p, r in pairs])


def _apart(
    view: View,
    places: Float64[np.ndarray, "marks 3"],
    directions: Float64[np.ndarray, "marks 2"],
) -> Float64[np.ndarray, "marks 2"]:
    points = places @ view.rotation.T + view.translation
    return (directions - points[:, :2] / points[:, 2:]) * view.lens.matrix[[0, 1], [0, 1]]


def _eye(view: View) -> Float64[np.ndarray, " 3"]:
    return -view.rotation.T @ view.translation


def _starts(
    lens: Lens, places: Float64[np.ndarray, "marks 3"], seen: Float64[np.ndarray, "marks 2"]
) -> list[Float64[np.ndarray, " 6"]]:
    """Poses to begin at: both of the flat problem, as OpenCV solves it."""
    cv2 = opencv()
    flat = places * [1.0, 1.0, 0.0]
    directions = lens.directions(seen)
    count, rotations, translations = cv2.solvePnPGeneric(
        flat[:, None], directions[:, None], np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
    )[:3]
    if not count:
        raise ValueError(
            "the marks tell no plane, expected four that aren't all on a line. Check x, y and "
            "near of each mark."
        )
    return [
        np.concatenate([rotation.ravel(), translation.ravel()])
        for rotation, translation in zip(rotations, translations, strict=True)
    ]


def _refined(
    lens: Lens,
    places: Float64[np.ndarray, "marks 3"],
    seen: Float64[np.ndarray, "marks 2"],
    radius: Float64[np.ndarray, " marks"],
    start: Float64[np.ndarray, " 6"],
) -> Marks:
    pose = start
    for _ in range(2):  # The centroids' offsets hardly depend on the pose.
        directions = lens.directions(seen - _offsets(view_of(lens, pose), places, radius))

        def misfit(
            pose: Float64[np.ndarray, " 6"],
            directions: Float64[np.ndarray, "marks 2"] = directions,
        ) -> Float64[np.ndarray, " numbers"]:
            return _apart(view_of(lens, pose), places, directions).ravel()

        pose = scipy.optimize.least_squares(
            misfit, pose, loss="soft_l1", f_scale=_SCALE, x_scale=np.full(6, 1e-2), xtol=1e-12
        ).x
    return Marks(view_of(lens, pose), misfit(pose).reshape(-1, 2))
