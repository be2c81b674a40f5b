"""A camera before the marks' plane: what is where in the picture, and back."""

import dataclasses

import numpy as np
from jaxtyping import Float64

from identification.vision.lens.lens import Lens

_CORNERS = 32
_STEP = 1e-4


@dataclasses.dataclass(frozen=True)
class View:
    """A lens and where it stands in the frame's coordinates."""

    lens: Lens
    """The lens."""
    rotation: Float64[np.ndarray, "3 3"]
    """From the frame's axes to the camera's."""
    translation: Float64[np.ndarray, " 3"]
    """The frame's origin in the camera's coordinates [m]."""

    def pixels(self, places: Float64[np.ndarray, "*many 3"]) -> Float64[np.ndarray, "*many 2"]:
        """Where places are seen.

        Args:
            places: In the frame's coordinates, the third towards the camera [m].

        Returns:
            Pixels [px].
        """
        return self.lens.pixels(places @ self.rotation.T + self.translation)

    def places(
        self,
        pixels: Float64[np.ndarray, "*many 2"],
        depth: Float64[np.ndarray, "*depths"] | float,
    ) -> Float64[np.ndarray, "*many 2"]:
        """What pixels see at a depth before the marks' plane.

        Args:
            pixels: Pixels [px].
            depth: Distance from the plane, towards the camera [m].

        Returns:
            Places x, y in the frame's coordinates [m].
        """
        directions = self.lens.directions(pixels)
        rays = np.concatenate([directions, np.ones((*directions.shape[:-1], 1))], axis=-1)
        rays = rays @ self.rotation
        eye = -self.rotation.T @ self.translation
        length = (np.asarray(depth) - eye[2]) / rays[..., 2]
        return eye[:2] + rays[..., :2] * length[..., None]

    def footprint(self, place: Float64[np.ndarray, " 3"]) -> Float64[np.ndarray, "2 2"]:
        """How a small piece parallel to the plane is mapped.

        Args:
            place: Where it is [m].

        Returns:
            Pixels for a metre along x and along y, as columns [px/m].
        """
        steps = np.zeros((4, 3))
        steps[0, 0] = steps[1, 1] = _STEP
        steps[2, 0] = steps[3, 1] = -_STEP
        seen = self.pixels(place + steps)
        return ((seen[:2] - seen[2:]) / (2 * _STEP)).T

    def centroid_offset(
        self, places: Float64[np.ndarray, "many 3"], radius: float
    ) -> Float64[np.ndarray, "many 2"]:
        """How far the centroid of a disc's image is from its centre's.

        The image of a disc is no disc: perspective makes the nearer half larger, and the lens
        bends its edge.

        Args:
            places: Centres of discs parallel to the plane [m].
            radius: Their radius [m].

        Returns:
            Centroid less centre [px].
        """
        angle = 2 * np.pi / _CORNERS * np.arange(_CORNERS)
        edge = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1) * radius
        centre = self.pixels(places)
        x, y = np.moveaxis(self.pixels(places[:, None] + edge) - centre[:, None], -1, 0)
        after_x, after_y = np.roll(x, -1, axis=-1), np.roll(y, -1, axis=-1)
        cross = x * after_y - after_x * y
        moments = [((x + after_x) * cross).sum(-1), ((y + after_y) * cross).sum(-1)]
        return np.stack(moments, axis=-1) / (3 * cross.sum(-1))[:, None]
