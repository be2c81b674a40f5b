"""A film of a rig as a folder: video, `vision.toml`, stamps, photos of a board, its truth."""

import dataclasses

import cv2
import numpy as np
from rig_camera import Camera, Sight
from rig_pictures import developed, jpeg, write_avi, write_mp4
from rig_video import (
    HEIGHT,
    HUES,
    MARKERS,
    MARKS,
    Film,
    Renderer,
)

COLUMNS = ("x_e", "y_e", "delta_e", "q_3", "q_4")


@dataclasses.dataclass(frozen=True)
class Truth:
    """What was filmed."""

    time: np.ndarray
    values: dict[str, np.ndarray]
    visible: np.ndarray
    again: np.ndarray


def easy(seed, **changes):
    random = np.random.default_rng(seed)
    camera = Camera(exposure=1e-3, readout=0.0, lateral=0.0, **_stand(random))
    return _film(camera, seed, {"clutter": 0, "quality": 95, **changes})


def usual(seed, **changes):
    random = np.random.default_rng(seed)
    return _film(Camera(**_stand(random)), seed, changes)


def hard(seed, **changes):
    random = np.random.default_rng(seed)
    frames = changes.get("frames", 60)
    camera = Camera(
        upside_down=True,
        exposure=14e-3,
        readout=27e-3,
        flicker=0.04,
        shake=1.5,
        blur=0.9,
        gain=0.7,
        **_stand(random),
    )
    losses = random.choice(np.arange(3, frames - 3), 6, replace=False)
    settings = {
        "arm": True,
        "speed": 1.2,
        "clutter": 12,
        "quality": 75,
        "dropped": tuple(sorted(losses[:3].tolist())),
        "doubled": tuple(sorted(losses[3:].tolist())),
    }
    return _film(camera, seed, {**settings, **changes})


def _stand(random):
    k1 = random.uniform(-0.2, 0.05)
    return {
        "position": (
            1.11 + random.uniform(-0.15, 0.15),
            0.556 + random.uniform(-0.12, 0.12),
            random.uniform(2.05, 2.3),
        ),
        "tilt": random.uniform(-3, 3),
        "pan": random.uniform(-3, 3),
        "roll": random.uniform(-4, 4),
        "distortion": (k1, -0.4 * k1, *random.uniform(-8e-4, 8e-4, 2), 0.0),
    }


def _film(camera, seed, changes):
    lens = {key: changes.pop(key) for key in ("size",) if key in changes}
    return Film(camera=dataclasses.replace(camera, **lens), seed=seed, **changes)


def shoot(film, folder, *, videos=("avi",), boards=0, coordinates=None):
    """Write a film's folder, of a motion that is given or the film's own.

    Returns the truth: poses at each stored picture's time.
    """
    folder.mkdir(parents=True, exist_ok=True)
    renderer = Renderer(film, coordinates)
    random = np.random.default_rng(film.seed + 5)
    stored, times, again, visible = [], [], [], []
    for k in range(film.frames):
        t = film.begin + k / film.rate + random.normal(0, 1e-4)
        if k in film.doubled and stored:
            picture = stored[-1]
        elif k in film.dropped:
            continue
        else:
            light = renderer.frame(t)
            picture = jpeg(developed(film.camera, light, random), film.quality)
        again.append(k in film.doubled and bool(stored))
        visible.append(renderer.visible(t))
        stored.append(picture)
        times.append(t)
    if "avi" in videos:
        write_avi(folder / "video.avi", stored, film.camera.size, film.rate)
    if "mp4" in videos:
        write_mp4(folder / "video.mp4", stored, film.camera.size, film.rate)
    if boards:
        photograph(film.camera, folder / "board", boards, random)
    times = np.array(times)
    stamped = bool(film.dropped or film.doubled)
    if stamped:
        rows = [f"{k},{t:.6f}" for k, t in enumerate(times)]
        (folder / "frames.csv").write_text("\n".join(["frame,t [s]", *rows]) + "\n")
    text = document(film, random, boards=boards > 0, stamped=stamped)
    (folder / "vision.toml").write_text(text)
    coordinates = renderer.coordinates(times)
    values = {name: coordinates[name] for name in COLUMNS}
    return Truth(times, values, np.array(visible), np.array(again))


def document(film, random, *, boards, stamped):
    """A film's `vision.toml`, clicked by a hand that isn't steady."""
    camera = film.camera
    lines = [
        "format = 1",
        'video = "video.avi"',
        f'frame_height = "{1e3 * HEIGHT:g} mm"',
        "[time]",
    ]
    lines += ['stamps = "frames.csv"'] if stamped else [f'frame_rate = "{film.rate:g} Hz"']
    lines += [
        f'first_frame = "{film.begin} s"',
        f'exposure = "{1e3 * camera.exposure:g} ms"',
        f'readout = "{1e3 * camera.readout:g} ms"',
        f'readout_direction = "{"up" if camera.upside_down else "down"}"',
        "[calibration]",
    ]
    if boards:
        lines += ['photos = "board/*.jpg"', "inner_corners = [9, 6]", 'square = "40 mm"']
    else:
        lines += [
            f"matrix = {camera.stored_matrix.tolist()}",
            f"distortion = {[float(k) for k in camera.stored_distortion]}",
        ]
    for name, (low, high) in HUES.items():
        lines += [f"[colours.{name}]", f'hue = ["{low} deg", "{high} deg"]']
        lines += ['saturation = ["45 %", "100 %"]', 'value = ["12 %", "100 %"]']
    for name in film.marks:
        x, y = MARKS[name]
        pixel = camera.pixels(np.array([x, y, 0.0]))
        if camera.upside_down:
            pixel = np.array(camera.size) - 1 - pixel
        near = np.round(pixel + random.uniform(-5, 5, 2)).tolist()
        lines += [
            "[[marks]]",
            f'name = "{name}"',
            f'x = "{1e3 * x:g} mm"',
            f'y = "{1e3 * y:g} mm"',
        ]
        lines += ['colour = "yellow"', 'diameter = "44 mm"', f"near = {near}"]
    for body, x, y, colour in MARKERS:
        lines += [
            "[[markers]]",
            f'body = "{body}"',
            f'x = "{1e3 * x:g} mm"',
            f'y = "{1e3 * y:g} mm"',
        ]
        lines += ['depth = "20 mm"', f'colour = "{colour}"', 'diameter = "40 mm"']
    return "\n".join(lines) + "\n"


def photograph(camera, folder, count, random):
    """Photos of a board of 9 by 6 inner corners, at changing places and tilts."""
    folder.mkdir(exist_ok=True)
    rays = Sight(camera)
    for number in range(count):
        tilt = np.array([[0.5, 0.2], [-0.5, 0.1], [0.1, 0.5], [-0.1, -0.5]])[number % 4]
        tilt = tilt + random.uniform(-0.15, 0.15, 2)
        turn = cv2.Rodrigues(np.array([*tilt, random.uniform(-0.3, 0.3)]))[0]
        far = random.uniform(0.6, 0.75)
        spread = np.array([(number % 3 - 1) * 0.30, (number // 3 % 3 - 1) * 0.21]) * far
        centre = np.array([*spread, far])
        middle = turn @ np.array([0.16, 0.10, 0.0])
        light = np.stack(
            [board_light(rays, turn, centre - middle, share=share) for share in (-1, 0, 1)], -1
        )
        picture = developed(camera, light, random)
        (folder / f"{number:02}.jpg").write_bytes(jpeg(picture, 92))


def board_light(rays, turn, place, *, share):
    """A chessboard on a wall: edges are ramps as wide as a pixel, which no side prefers."""
    v, u = np.mgrid[: rays.ray.shape[0], : rays.ray.shape[1]]
    off = share * rays.camera.lateral * (np.stack([u, v], -1) - rays.camera.matrix[:2, 2])
    ray = rays.ray - off[..., :1] * rays.ray_u - off[..., 1:] * rays.ray_v
    direction = np.concatenate([ray, np.ones((*ray.shape[:2], 1))], -1) @ turn
    eye = -turn.T @ place
    at = eye[:2] - direction[..., :2] * (eye[2] / direction[..., 2])[..., None]
    squares = at / 0.04 + 1
    # How many squares a pixel goes on along each of the board's axes.
    wide = np.hypot(np.gradient(squares, axis=0), np.gradient(squares, axis=1))
    whole = np.floor(squares)
    off = np.abs(squares - np.round(squares)) / wide
    wave = (1 - 2 * (whole % 2)) * np.clip(2 * off, 0, 1)
    on = (squares > -0.5).all(-1) & (squares[..., 0] < 10.5) & (squares[..., 1] < 7.5)
    inside = (squares > 0).all(-1) & (squares[..., 0] < 10) & (squares[..., 1] < 7)
    checker = 0.39 - 0.36 * wave.prod(-1)
    return np.where(inside, checker, np.where(on, 0.75, 0.6))
