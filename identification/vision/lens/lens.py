"""A lens: where in the picture a direction is seen, and back."""

import dataclasses

import numpy as np
from jaxtyping import Float64

from identification.vision.pictures.opencv import opencv

_STEPS = 60
_CLOSE = 1e-11


@dataclasses.dataclass(frozen=True)
class Lens:
    """A pinhole with OpenCV's distortion; a pixel's centre has whole coordinates."""

    matrix: Float64[np.ndarray, "3 3"]
    """Focal lengths and principal point [px]."""
    distortion: Float64[np.ndarray, " terms"]
    """k1, k2, p1, p2, k3, … [1]."""
    rms: float | None = None
    """Root mean square of the board's corners about the fit [px]; None if it was stated."""
    deviations: Float64[np.ndarray, "directions parameters"] = dataclasses.field(
        default_factory=lambda: np.zeros((0, 9))
    )
    """A square root of the covariance: rows of what fx, fy, cx, cy and five terms of the
    distortion may be off by together, their squares to be added up."""

    @property
    def focal_length(self) -> float:
        """Mean focal length [px]."""
        return float(np.sqrt(self.matrix[0, 0] * self.matrix[1, 1]))

    lateral: float = 0.0
    """How much more blue is magnified than red [1], see `lateral`."""

    def without_colour(
        self, pixels: Float64[np.ndarray, "*many 2"], magnification: float
    ) -> Float64[np.ndarray, "*many 2"]:
        """Pixels as grey light would have them.

        Args:
            pixels: Where a colour is seen [px].
            magnification: How much more than grey it is magnified [1].

        Returns:
            Where grey would be [px].
        """
        return pixels - magnification * (pixels - self.matrix[:2, 2])

    def changed(self, change: Float64[np.ndarray, " parameters"]) -> "Lens":
        """The lens with other numbers.

        Args:
            change: What is added to fx, fy, cx, cy and five terms of the distortion.

        Returns:
            The other lens.
        """
        matrix, distortion = self.matrix.copy(), self.distortion.copy()
        matrix[[0, 1, 0, 1], [0, 1, 2, 2]] += change[:4]
        distortion[:5] += change[4 : 4 + len(distortion[:5])]
        return dataclasses.replace(self, matrix=matrix, distortion=distortion)

    def directions(
        self, pixels: Float64[np.ndarray, "*many 2"]
    ) -> Float64[np.ndarray, "*many 2"]:
        """Where pixels look, at unit distance before the camera.

        Args:
            pixels: Pixels as they are stored [px].

        Returns:
            Directions without distortion [1]; NaN where the pixel is.
        """
        if not np.size(pixels):
            return np.zeros(np.shape(pixels))
        seen = np.isfinite(pixels).all(axis=-1, keepdims=True)
        wanted = np.where(seen, pixels, self.matrix[:2, 2])
        scale = self.matrix[[0, 1], [0, 1]]
        found = (wanted - self.matrix[:2, 2]) / scale
        for _ in range(_STEPS):
            # The distortion is a small part of the whole, so this contracts.
            points = np.concatenate([found, np.ones((*found.shape[:-1], 1))], axis=-1)
            step = (wanted - self.pixels(points)) / scale
            found = found + step
            if np.abs(step).max() < _CLOSE:
                break
        return np.where(seen, found, np.nan)

    def pixels(self, points: Float64[np.ndarray, "*many 3"]) -> Float64[np.ndarray, "*many 2"]:
        """Where points before the camera are seen.

        Args:
            points: Points in the camera's coordinates [m].

        Returns:
            Pixels [px].
        """
        flat = np.ascontiguousarray(points, float).reshape(-1, 1, 3)
        zero = np.zeros(3)
        found, _ = opencv().projectPoints(flat, zero, zero, self.matrix, self.distortion)
        return found.reshape(*np.shape(points)[:-1], 2)
