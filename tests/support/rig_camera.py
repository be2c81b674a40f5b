"""A camera before a rig, for rendering: where a piece of a pixel looks, and at what time."""

import dataclasses

import cv2
import numpy as np


@dataclasses.dataclass(frozen=True)
class Camera:
    """A camera as it stands, and how its sensor works."""

    size: tuple[int, int] = (816, 612)
    field_of_view: float = 66.0
    principal: tuple[float, float] = (4.6, -3.4)
    distortion: tuple[float, ...] = (-0.11, 0.045, 0.0006, -0.0004, 0.0)
    position: tuple[float, float, float] = (1.17, 0.62, 2.03)
    tilt: float = -2.0
    pan: float = -1.6
    roll: float = -1.2
    upside_down: bool = False
    exposure: float = 4e-3
    readout: float = 22e-3
    instants: int = 7
    blur: float = 0.75
    lateral: float = 1.5e-4
    noise: bool = True
    gain: float = 0.8
    flicker: float = 0.0
    shake: float = 0.0

    @property
    def matrix(self):
        width, height = self.size
        focal = width / 2 / np.tan(np.radians(self.field_of_view) / 2)
        u, v = (width - 1) / 2 + self.principal[0], (height - 1) / 2 + self.principal[1]
        return np.array([[focal, 0, u], [0, focal, v], [0, 0, 1.0]])

    @property
    def stored_matrix(self):
        """Matrix of the stored picture, which may be upside down."""
        matrix = self.matrix
        if self.upside_down:
            matrix[0, 2] = self.size[0] - 1 - matrix[0, 2]
            matrix[1, 2] = self.size[1] - 1 - matrix[1, 2]
        return matrix

    @property
    def stored_distortion(self):
        k1, k2, p1, p2, k3 = self.distortion
        return (k1, k2, -p1, -p2, k3) if self.upside_down else self.distortion

    @property
    def rotation(self):
        tilt, pan, roll = np.radians([self.tilt, self.pan, self.roll])
        about_x = np.array(
            [[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]]
        )
        about_y = np.array(
            [[np.cos(pan), 0, np.sin(pan)], [0, 1, 0], [-np.sin(pan), 0, np.cos(pan)]]
        )
        about_z = np.array(
            [[np.cos(roll), -np.sin(roll), 0], [np.sin(roll), np.cos(roll), 0], [0, 0, 1]]
        )
        return about_z @ about_x @ about_y @ np.diag([1.0, -1.0, -1.0])

    def pixels(self, places):
        """Where places are seen on the sensor."""
        points = (np.asarray(places, float) - self.position) @ self.rotation.T
        flat = points.reshape(-1, 1, 3)
        zero = np.zeros(3)
        seen, _ = cv2.projectPoints(flat, zero, zero, self.matrix, np.array(self.distortion))
        return seen.reshape(*points.shape[:-1], 2)

    def rays(self):
        """Direction of each pixel of the sensor without distortion, height by width by 2."""
        width, height = self.size
        grid = np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1).astype(float)
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 60, 1e-12)
        found = cv2.undistortPoints(
            grid.reshape(-1, 1, 2),
            self.matrix,
            np.array(self.distortion),
            None,
            None,
            None,
            criteria,
        )
        return found.reshape(height, width, 2)

    def row_time(self, rows):
        """How much later than the middle row a row of the sensor is exposed [s]."""
        height = self.size[1]
        return (rows - (height - 1) / 2) / (height - 1) * self.readout


class Sight:
    """What pieces of pixels see of a plane."""

    def __init__(self, camera, samples=4):
        self.camera = camera
        self.samples = samples
        self.ray = camera.rays()
        self.ray_u = np.gradient(self.ray, axis=1)
        self.ray_v = np.gradient(self.ray, axis=0)

    def window(self, low, high):
        """Rows and columns of a window, cut to the sensor."""
        width, height = self.camera.size
        low = np.clip(np.floor(low).astype(int), 0, [width, height])
        high = np.clip(np.ceil(high).astype(int) + 1, 0, [width, height])
        return slice(low[1], high[1]), slice(low[0], high[0])

    def places(self, rows, columns, depth, shift, samples=None):
        """Places at a depth that pieces of a window's pixels see: rows, columns, pieces, 2."""
        count = samples or self.samples
        inner = (np.arange(count) + 0.5) / count - 0.5
        du, dv = (each.ravel() for each in np.meshgrid(inner, inner))
        ray, along_u, along_v = (
            each[rows, columns, None] for each in (self.ray, self.ray_u, self.ray_v)
        )
        shift = np.broadcast_to(shift, (*ray.shape[:3], 2))
        offset_u, offset_v = du - shift[..., 0], dv - shift[..., 1]
        seen = ray + offset_u[..., None] * along_u + offset_v[..., None] * along_v
        rotation, eye = self.camera.rotation, np.array(self.camera.position)
        whole = np.concatenate([seen, np.ones((*seen.shape[:-1], 1))], -1) @ rotation
        length = (depth - eye[2]) / whole[..., 2]
        return eye[:2] + whole[..., :2] * length[..., None]
