r"""How far each column may be off: what varies from picture to picture, and what doesn't.

Four things are told by the video itself.
Noise of a marker, with all that depends on where its disc lies on the pixels: a rigid body's
markers must keep their distances and a carriage its height, so what these do is error. It is
estimated from them, in pixels.
The marks' own errors, and with them the plane's: by the marks' residuals, and how a mark
that is off moves everything.
The lens: by the covariance of its fit to the board, the plane fitted anew with each lens that
might be as well.
Lateral colour, which is corrected by what the board tells of it: see `lens.lateral`.
A repeated measurement of a still robot would show the first alone, and be off by the others
without knowing.
"""

import dataclasses

import numpy as np
from jaxtyping import Float64

from identification.vision.lens import Marks, View
from identification.vision.poses import COLUMNS, Poses
from identification.vision.settings.document import Vision
from identification.vision.spots.bodies import of_bodies
from identification.vision.uncertainty.noise import Noise, noise_of
from identification.vision.uncertainty.systematic import systematic_variances

_SAMPLES = 12


@dataclasses.dataclass(frozen=True)
class Sigma:
    """Standard deviations of the columns of `camera.csv`."""

    columns: dict[str, float]
    """Of each but the time [m, rad]; NaN where a column is empty."""
    noise: Noise
    """What of it varies from picture to picture."""

    @property
    def position(self) -> float:
        """Root mean square of the positions' [m]."""
        known = [self.columns[name] for name in COLUMNS if name != "delta_e"]
        known = [each for each in known if np.isfinite(each)]
        return float(np.sqrt(np.mean(np.square(known)))) if known else float("nan")

    @property
    def angle(self) -> float:
        """The angle's [rad]."""
        return self.columns["delta_e"]


def sigma_of(
    vision: Vision,
    marks: Marks,
    mark_pixels: Float64[np.ndarray, "marks 2"],
    poses: Poses,
    misfit: Float64[np.ndarray, " markers"],
) -> Sigma:
    """How far the poses may be off.

    Args:
        vision: What is said of the video.
        marks: The marks' plane.
        mark_pixels: Where the marks are seen in the mean, NaN where they aren't [px].
        poses: The poses.
        misfit: How much the markers' discs are unlike their shape [1].

    Returns:
        Standard deviations.
    """
    places = _typical(poses)
    noise = noise_of(vision, poses, _pixel_sizes(marks.view, vision, places), misfit)
    variances = systematic_variances(vision, marks, mark_pixels, places)
    for body, members in of_bodies(vision):
        _add_noise(variances, vision, body, members, noise)
    columns = {
        name: float(np.sqrt(variances[name]))
        if np.isfinite(poses.values[name]).any()
        else float("nan")
        for name in COLUMNS
    }
    return Sigma(columns, noise)


def _typical(poses: Poses) -> Float64[np.ndarray, "samples markers 2"]:
    """Where the markers were: some pictures from the whole of the track."""
    whole = np.flatnonzero(np.isfinite(poses.places[..., 0]).all(axis=1))
    if not len(whole):
        return _medians(poses.places)[None]
    chosen = whole[np.linspace(0, len(whole) - 1, min(len(whole), _SAMPLES)).astype(int)]
    return poses.places[chosen]


def _medians(
    places: Float64[np.ndarray, "frames markers 2"],
) -> Float64[np.ndarray, "markers 2"]:
    """Of each marker; NaN of those that were never seen."""
    medians = np.full(places.shape[1:], np.nan)
    for k in range(len(medians)):
        seen = places[np.isfinite(places[:, k, 0]), k]
        if len(seen):
            medians[k] = np.median(seen, axis=0)
    return medians


def _pixel_sizes(
    view: View, vision: Vision, places: Float64[np.ndarray, "samples markers 2"]
) -> Float64[np.ndarray, " markers"]:
    """What a pixel is at each marker [m]."""
    sizes = []
    for k, marker in enumerate(vision.markers):
        at = places[:, k].mean(axis=0)
        if not np.isfinite(at).all():
            sizes.append(np.nan)
            continue
        footprint = view.footprint(np.array([*at, marker.depth]))
        sizes.append(1 / np.sqrt(abs(np.linalg.det(footprint))))
    return np.array(sizes)


def _add_noise(
    variances: dict[str, float],
    vision: Vision,
    body: str,
    members: list[int],
    noise: Noise,
) -> None:
    """What independent noise of the markers adds, and what they have in common."""
    along_x, along_y = (noise.own[:, members] ** 2).mean(axis=1)
    shared_x, shared_y = (noise.rows[:, members] ** 2).mean(axis=1) + noise.common**2
    if body != "end_effector":
        name = "q_3" if body == "lower_carriage" else "q_4"
        variances[name] += along_x / len(members) + shared_x
        return
    own = np.array([[vision.markers[k].x, vision.markers[k].y] for k in members])
    middle = own.mean(axis=0)
    arm = own - middle
    # A marker turns the body by its move across its arm.
    inertia = (arm**2).sum()
    turn = ((arm[:, 0] ** 2).sum() * along_y + (arm[:, 1] ** 2).sum() * along_x) / inertia**2
    variances["delta_e"] += turn
    variances["x_e"] += along_x / len(members) + turn * middle[1] ** 2 + shared_x
    variances["y_e"] += along_y / len(members) + turn * middle[0] ** 2 + shared_y
