"""A video of a rig with known poses, drawn from scratch: exact coverage, rows at their times.

OpenCV's own drawing and warping are off by some hundredths of a pixel, so discs are drawn by
asking of each of 16 pieces of a pixel, at each of several instants of its own row's exposure,
whether it sees the disc. What the camera then does to the light is done in order: lateral
colour, blur, noise, a Bayer pattern, a curve, JPEG with half the chroma.
"""

import dataclasses

import cv2
import numpy as np
from rig_camera import Camera, Sight

COLOURS = {
    "yellow": (0.02, 0.55, 0.72),
    "green": (0.05, 0.33, 0.02),
    "blue": (0.5, 0.09, 0.02),
    "red": (0.03, 0.02, 0.55),
}
"""Light of the discs, BGR."""
BLACK, WALL = (0.018, 0.016, 0.016), (0.38, 0.45, 0.5)
HUES = {"yellow": (38, 66), "green": (100, 170), "blue": (195, 245), "red": (340, 20)}
MARKS = {
    "lower_left": (-0.045, -0.045),
    "lower_right": (2.269, -0.045),
    "right": (2.269, 0.5),
    "upper_right": (2.269, 1.157),
    "upper_left": (-0.045, 1.157),
    "left": (-0.045, 0.62),
}
MARKERS = (
    ("end_effector", -0.11, 0.0, "green"),
    ("end_effector", 0.11, 0.0, "green"),
    ("lower_carriage", 0.0, -0.045, "blue"),
    ("upper_carriage", 0.0, 0.045, "red"),
)
HEIGHT, DEPTH, MARK_RADIUS, MARKER_RADIUS = 1.112, 0.02, 0.022, 0.02


@dataclasses.dataclass(frozen=True)
class Film:
    """What is filmed, and how it is stored."""

    camera: Camera = dataclasses.field(default_factory=Camera)
    seed: int = 0
    frames: int = 60
    rate: float = 30.0
    begin: float = 0.05
    clutter: int = 8
    arm: bool = False
    arm_light: tuple[float, float, float] = (0.12, 0.2, 0.35)
    speed: float = 1.0
    dropped: tuple[int, ...] = ()
    doubled: tuple[int, ...] = ()
    quality: int = 85
    marks: tuple[str, ...] = tuple(MARKS)


def motion(film):
    """The robot's coordinates as functions of time: legs with vibration, from a seed."""
    random = np.random.default_rng(film.seed + 77)
    long = film.frames / film.rate
    count = max(2, int(long / 1.2))
    times = (
        film.begin + 0.25 + (np.arange(count) + random.uniform(0, 0.2, count)) * long / count
    )
    ends = 0.35 + 1.5 * ((np.arange(count + 1) % 2) * 0.6 + 0.2 * random.random(count + 1))
    height = random.uniform(0.25, 0.8)
    rise = random.uniform(-0.1, 0.1)
    ring = random.uniform(3.0, 5.0)
    swing = random.uniform(0.003, 0.008) * film.speed

    def step(t, start, duration):
        s = np.clip((t - start) / duration, 0, 1)
        return s**3 * (10 - 15 * s + 6 * s**2)

    def coordinates(t):
        t = np.asarray(t, float)
        duration = 0.95 / film.speed
        x, wave = np.full_like(t, ends[0]), np.zeros_like(t)
        for k, start in enumerate(times):
            x = x + (ends[k + 1] - ends[k]) * step(t, start, duration)
            late = np.clip(t - start, 0, None)
            wave = wave + np.exp(-2.5 * late) * np.sin(2 * np.pi * ring * late) * (
                1 - np.exp(-40 * late)
            )
        y = height + rise * step(t, times[0], 1.5)
        q_3 = x + 0.4 * swing * wave
        q_4 = x - 0.3 * swing * wave + 0.006
        return {
            "x_e": x + swing * wave,
            "y_e": y,
            "delta_e": -0.005 + 2.5 * swing * wave,
            "q_3": q_3,
            "q_4": q_4,
        }

    return coordinates


def marker_places(coordinates):
    """Where the markers are: markers first, then the coordinates' shape, 2."""
    turn = np.cos(coordinates["delta_e"]), np.sin(coordinates["delta_e"])
    places = []
    for body, x, y, _ in MARKERS:
        if body == "end_effector":
            at = coordinates["x_e"] + turn[0] * x - turn[1] * y
            places.append((at, coordinates["y_e"] + turn[1] * x + turn[0] * y))
        elif body == "lower_carriage":
            places.append((coordinates["q_3"] + x, np.full_like(coordinates["q_3"], y)))
        else:
            places.append(
                (coordinates["q_4"] + x, np.full_like(coordinates["q_4"], HEIGHT + y))
            )
    return np.array([np.stack(each, -1) for each in places])


class Renderer:
    """What draws a film."""

    def __init__(self, film, coordinates=None):
        self.film, self.camera = film, film.camera
        self.sight = Sight(film.camera)
        self.random = np.random.default_rng(film.seed)
        self.coordinates = coordinates or motion(film)
        self.phases = self.random.uniform(0, 2 * np.pi, (2, 3))
        share = (np.arange(self.camera.instants) + 0.5) / self.camera.instants - 0.5
        self.instants = share * self.camera.exposure
        self.still = self._wall()

    def shift(self, t):
        """How far the tripod's shaking moves the picture [px]."""
        rates = np.array([1.7, 4.1, 7.3])
        waves = np.sin(2 * np.pi * rates * np.asarray(t)[..., None, None] + self.phases)
        return self.camera.shake * (waves * [0.6, 0.5, 0.3]).sum(-1)

    def frame(self, t):
        """Light on the sensor, for a frame of a time."""
        rows = np.arange(self.camera.size[1])
        shift = self.shift(t)
        light = cv2.warpAffine(
            self.still,
            np.array([[1, 0, shift[0]], [0, 1, shift[1]]]),
            self.camera.size,
            borderMode=cv2.BORDER_REPLICATE,
        )
        for name in self.film.marks:
            self._plate(light, t, lambda s, at=MARKS[name]: np.array(at), 0.034, 0.034, 0.0)
            self._disc(
                light, t, lambda s, at=MARKS[name]: np.array(at), 0.0, MARK_RADIUS, "yellow"
            )

        def end_effector(s):
            c = self.coordinates(s)
            return np.stack([c["x_e"], c["y_e"]], -1)

        self._plate(light, t, end_effector, 0.145, 0.145, DEPTH, turned=True)
        for k, (body, _, _, colour) in enumerate(MARKERS):

            def centre(s, k=k):
                return marker_places(self.coordinates(s))[k]

            if body != "end_effector":
                lower = 0.02 if body == "lower_carriage" else -0.02
                self._plate(
                    light,
                    t,
                    lambda s, c=centre, d=lower: c(s) + np.array([0, d]),
                    0.055,
                    0.05,
                    DEPTH,
                )
            self._disc(light, t, centre, DEPTH, MARKER_RADIUS, colour)
        if self.film.arm:
            self._arm(light, t)
        if self.camera.flicker:
            when = t + self.camera.row_time(rows)
            light *= (1 + self.camera.flicker * np.sin(2 * np.pi * 100 * when))[:, None, None]
        return light

    def visible(self, t):
        """Share of each marker that the arm leaves."""
        if not self.film.arm:
            return np.ones(len(MARKERS))
        angle, radius = np.meshgrid(
            np.linspace(0, 2 * np.pi, 40), np.sqrt(np.linspace(0, 1, 12))
        )
        disc = MARKER_RADIUS * np.stack([radius * np.cos(angle), radius * np.sin(angle)], -1)
        shares = []
        for k in range(len(MARKERS)):
            when = t + self.camera.row_time(self.marker_pixels(t)[k, 1])
            covered = np.zeros(disc.shape[:2], bool)
            # Hidden in a part of the exposure is hidden.
            for s in when + np.linspace(-0.5, 0.5, 5) * self.camera.exposure:
                at = marker_places(self.coordinates(s))[k] + disc
                seen = self.camera.pixels(
                    np.concatenate([at, np.full((*at.shape[:2], 1), DEPTH)], -1)
                )
                covered |= self._arm_distance(seen, s) < 3.0
            shares.append(1 - covered.mean())
        return np.array(shares)

    def marker_pixels(self, t):
        """Where the markers' centres are seen, each at its own row's time."""
        pixels = np.zeros((len(MARKERS), 2))
        for k in range(len(MARKERS)):
            row = self.camera.size[1] / 2
            for _ in range(4):
                when = t + self.camera.row_time(row)
                at = np.array([*marker_places(self.coordinates(when))[k], DEPTH])
                pixels[k] = self.camera.pixels(at) + self.shift(when)
                row = pixels[k, 1]
        return pixels

    def _times(self, rows, t):
        """Instants of the exposure of rows: rows by instants."""
        return (
            t + self.camera.row_time(np.arange(rows.start, rows.stop))[:, None] + self.instants
        )

    def _box(self, t, centre, half, depth):
        around = t + np.linspace(-0.5, 0.5, 5) * (self.camera.readout + self.camera.exposure)
        at = np.array([np.broadcast_to(centre(s), (2,)) for s in around])
        corners = at[:, None] + half * np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])
        seen = self.camera.pixels(
            np.concatenate([corners, np.full((*corners.shape[:2], 1), depth)], -1)
        ).reshape(-1, 2)
        margin = 3 + 2 * self.camera.shake
        return self.sight.window(seen.min(0) - margin, seen.max(0) + margin)

    def _disc(self, light, t, centre, depth, radius, colour):
        rows, columns = self._box(t, centre, radius, depth)
        if rows.stop <= rows.start or columns.stop <= columns.start:
            return
        times = self._times(rows, t)
        middle = self.camera.matrix[:2, 2]
        v, u = np.mgrid[rows, columns]
        from_middle = np.stack([u, v], -1) - middle
        for channel, share in enumerate((-1, 0, 1)):
            cover = 0.0
            for j in range(times.shape[1]):
                shift = (
                    self.shift(times[:, j])[:, None] + share * self.camera.lateral * from_middle
                )
                places = self.sight.places(rows, columns, depth, shift[:, :, None])
                at = np.broadcast_to(centre(times[:, j]), (len(times), 2))[:, None, None]
                cover = cover + (((places - at) ** 2).sum(-1) < radius**2).mean(-1)
            cover = cover / times.shape[1]
            patch = light[rows, columns, channel]
            patch += cover * (COLOURS[colour][channel] - patch)

    def _plate(self, light, t, centre, half_x, half_y, depth, turned=False):
        rows, columns = self._box(t, centre, 1.2 * max(half_x, half_y), depth)
        times = self._times(rows, t)[:, :: max(1, self.camera.instants // 3)]
        cover = 0.0
        for j in range(times.shape[1]):
            shift = self.shift(times[:, j])[:, None, None]
            places = self.sight.places(rows, columns, depth, shift, samples=2)
            off = places - np.broadcast_to(centre(times[:, j]), (len(times), 2))[:, None, None]
            if turned:
                angle = self.coordinates(times[:, j])["delta_e"][:, None, None]
                x = np.cos(angle) * off[..., 0] + np.sin(angle) * off[..., 1]
                y = -np.sin(angle) * off[..., 0] + np.cos(angle) * off[..., 1]
            else:
                x, y = off[..., 0], off[..., 1]
            cover = cover + ((np.abs(x) < half_x) & (np.abs(y) < half_y)).mean(-1)
        cover = (cover / times.shape[1])[..., None]
        patch = light[rows, columns]
        patch += cover * (np.array(BLACK) - patch)

    def _arm_distance(self, pixels, t):
        """Distance from the arm, negative inside [px]."""
        width, height = self.camera.size
        period = self.film.frames / self.film.rate / 2
        phase = (t - self.film.begin) / period
        tip = np.stack(
            [width * (0.15 + 0.7 * np.abs((phase % 2) - 1)), height * (0.55 + 0 * phase)], -1
        )
        root = np.stack([width * (0.3 + 0.1 * np.sin(phase)), height * (1.2 + 0 * phase)], -1)
        along = tip - root
        s = np.clip(((pixels - root) * along).sum(-1) / (along * along).sum(-1), 0, 1)
        return (
            np.hypot(*np.moveaxis(pixels - root - s[..., None] * along, -1, 0)) - 0.035 * width
        )

    def _arm(self, light, t):
        v, u = np.mgrid[: self.camera.size[1], : self.camera.size[0]]
        when = t + self.camera.row_time(v)
        pixels = np.stack([u, v], -1).astype(float)
        cover = np.clip(0.5 - self._arm_distance(pixels, when), 0, 1)[..., None]
        light += cover * (np.array(self.film.arm_light) - light)

    def _wall(self):
        width, height = self.camera.size
        light = np.ones((height, width, 3)) * WALL
        noise = self.random.normal(0, 1, (height // 40 + 2, width // 40 + 2))
        light *= (
            1
            + 0.03
            * cv2.resize(noise, (width, height), interpolation=cv2.INTER_CUBIC)[..., None]
        )
        tones = [*COLOURS.values()]
        for k in range(self.film.clutter):
            at = self.random.uniform([0, 0], [width, height])
            size = self.random.uniform(0.008, 0.03, 2) * width
            tone = np.array(tones[k % 4]) * self.random.uniform(0.4, 1.3) + self.random.uniform(
                0, 0.15
            )
            angle = self.random.uniform(0, 180)
            if k % 2:
                cv2.ellipse(
                    light, at.astype(int), size.astype(int), angle, 0, 360, tone.tolist(), -1
                )
            else:
                box = cv2.boxPoints((at.tolist(), (2 * size).tolist(), angle)).astype(int)
                cv2.fillPoly(light, [box], tone.tolist())
        return light
