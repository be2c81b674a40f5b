r"""How far each column may be off: what varies from picture to picture, and what doesn't.

Three things are told by the video itself.
Noise of a marker, with all that depends on where its disc lies on the pixels: by its disc's
picture, and by what its body doesn't allow, see `noise`.
The lens and the plane: by what the board's photos and the marks leave open together, see
`lens.adjusted`.
Lateral colour, which is corrected by what the board tells of it: see `lens.lateral`.
A repeated measurement of a still robot would show the first alone, and be off by the others
without knowing.
"""

import dataclasses

import numpy as np
from jaxtyping import Float64

from identification.vision.lens import Adjusted
from identification.vision.poses import COLUMNS, OF_BODY, Poses
from identification.vision.settings.document import Vision
from identification.vision.spots.bodies import of_bodies
from identification.vision.uncertainty.noise import Noise, noise_of
from identification.vision.uncertainty.systematic import systematic_variances

_SAMPLES = 12
_FAST, _OF_PLATE = 4.0, 0.3
"""A disc is fast where its variance along its path is more than so many times that across. Its
plate then lies on one side of it and the wall on the other, which is most of what it is off by.
The disc at the plate's other end is off the other way: this share stays in the mean of both, by
rendered films [1]."""


@dataclasses.dataclass(frozen=True)
class Sigma:
    """Standard deviations of the columns of `camera.csv`."""

    random: dict[str, float]
    """What varies from picture to picture, of each column but the time [m, rad]; NaN where a
    column is empty."""
    common: dict[str, float]
    """What doesn't, likewise."""
    noise: Noise
    """Where the first comes from."""

    @property
    def columns(self) -> dict[str, float]:
        """Of each column but the time, both parts together [m, rad]."""
        return {name: float(np.hypot(self.random[name], self.common[name])) for name in COLUMNS}

    @property
    def position(self) -> float:
        """Root mean square of the positions' [m]."""
        columns = self.columns
        known = [columns[name] for name in COLUMNS if name != "delta_e"]
        known = [each for each in known if np.isfinite(each)]
        return float(np.sqrt(np.mean(np.square(known)))) if known else float("nan")

    @property
    def angle(self) -> float:
        """The angle's [rad]."""
        return self.columns["delta_e"]


def sigma_of(
    vision: Vision,
    fit: Adjusted,
    poses: Poses,
    variance: Float64[np.ndarray, "frames markers 2"],
    shake: Float64[np.ndarray, "2 markers"],
) -> Sigma:
    """How far the poses may be off.

    Args:
        vision: What is said of the video.
        fit: The lens and the marks' plane.
        poses: The poses.
        variance: Of each marker's coordinates in each picture, by its disc [px²].
        shake: How far the shift at each marker's row is off along each direction [px].

    Returns:
        Standard deviations.
    """
    noise = noise_of(vision, fit.marks.view, poses, variance, shake)
    common = systematic_variances(vision, fit, _typical(poses))
    random: dict[str, float] = {}
    for body, members in of_bodies(vision):
        random |= _of_noise(vision, body, members, noise)
    return Sigma(_known(poses, random), _known(poses, common), noise)


def _known(poses: Poses, variances: dict[str, float]) -> dict[str, float]:
    """Standard deviations of the columns that aren't empty, NaN of the others."""
    return {
        name: float(np.sqrt(variances[name]))
        if np.isfinite(poses.values[name]).any()
        else float("nan")
        for name in COLUMNS
    }


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


def _of_noise(vision: Vision, body: str, members: list[int], noise: Noise) -> dict[str, float]:
    """What independent noise of a body's markers makes of its columns, and what all share."""
    along_x, along_y = (noise.own[:, members] ** 2).mean(axis=1)
    shake_x, shake_y = (noise.shake[:, members] ** 2).mean(axis=1)
    rows = {name: noise.rows[name] ** 2 for name in OF_BODY[body]}
    if body != "end_effector":
        return {name: along_x / len(members) + shake_x + each for name, each in rows.items()}
    own = np.array([[vision.markers[k].x, vision.markers[k].y] for k in members])
    middle = own.mean(axis=0)
    arm = own - middle
    # A marker turns the body by its move across its arm.
    inertia = (arm**2).sum()
    turn = ((arm[:, 0] ** 2).sum() * along_y + (arm[:, 1] ** 2).sum() * along_x) / inertia**2
    far = max(along_x - _FAST * along_y, 0.0)
    together = along_x - (1 - _OF_PLATE) * far
    return {
        "x_e": together / len(members) + turn * middle[1] ** 2 + shake_x + rows["x_e"],
        "y_e": along_y / len(members) + turn * middle[0] ** 2 + shake_y + rows["y_e"],
        "delta_e": turn + rows["delta_e"],
    }
