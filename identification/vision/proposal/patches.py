"""Round patches of strong colour, and the colours that there are."""

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Bool, Float64, UInt8

from identification.vision.pictures.opencv import opencv
from identification.vision.settings.document import WORDS

Picture = UInt8[np.ndarray, "height width 3"]

_STRONG, _BRIGHT = 0.45, 0.12
_LEAST_RADIUS, _MOST_RADIUS = 4.0, 80.0
_ROUND, _RAGGED, _STRETCHED = 0.955, 0.35, 1.35
_APART = 8.0
_FRAYED = 5


@dataclasses.dataclass(frozen=True)
class Disc:
    """A disc of some colour in one picture."""

    centre: Float64[np.ndarray, " 2"]
    """Its middle [px]."""
    radius: float
    """Radius of the circle of its area [px]."""
    hue: float
    """Its hue [deg]."""
    saturation: float
    """Its saturation [1]."""
    value: float
    """Its value [1]."""


def round_patches(picture: Picture) -> Iterator[Disc]:
    """Patches of strong colour that are round.

    Args:
        picture: The picture.

    Yields:
        Each, with its colour.
    """
    cv2 = opencv()
    tones = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV_FULL)
    mask = cv2.inRange(tones, (0, 255 * _STRONG, 255 * _BRIGHT), (255, 255, 255))
    # Half of the chroma is the neighbours', which frays the edge before a bright wall.
    round_ = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (_FRAYED, _FRAYED))
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, round_)
    _, labels, stats, centres = cv2.connectedComponentsWithStats(mask)
    for label in range(1, len(stats)):
        left, top, width, height, area = stats[label]
        radius = float(np.sqrt(area / np.pi))
        if not _LEAST_RADIUS <= radius <= _MOST_RADIUS:
            continue
        inside = labels[top : top + height, left : left + width] == label
        if not _is_round(inside):
            continue
        own = tones[top : top + height, left : left + width][_core(inside)].astype(float)
        turn = np.exp(1j * own[:, 0] * 2 * np.pi / 256).mean()
        yield Disc(
            np.asarray(centres[label], float),
            radius,
            float(np.degrees(np.angle(turn)) % 360),
            float(np.median(own[:, 1]) / 255),
            float(np.median(own[:, 2]) / 255),
        )


def _is_round(inside: Bool[np.ndarray, "height width"]) -> bool:
    r"""Whether a patch is an ellipse's, by its moments.

    A disc of variance $\sigma^2$ a direction has the area $4 \pi \sigma^2$ and the kurtosis
    $E r^4 / (E r^2)^2 = 4/3$; of a square both are 5 % off, to opposite sides.
    """
    points = np.argwhere(inside).astype(float)
    covariance = np.cov(points.T)
    values = np.linalg.eigvalsh(covariance)
    if values[0] <= 0 or values[1] > _STRETCHED**2 * values[0]:
        return False
    filled = len(points) / (4 * np.pi * np.sqrt(values[0] * values[1]))
    off = points - points.mean(axis=0)
    square = (off @ np.linalg.inv(covariance) * off).sum(axis=1)
    kurtosis = (square**2).mean() / square.mean() ** 2
    # A small one's edge has few pixels to be smooth with.
    least = _ROUND - _RAGGED / np.sqrt(len(points) / np.pi)
    return bool(least < filled * (4 / 3) / kurtosis < 1 / least)


def _core(inside: np.ndarray) -> np.ndarray:
    """A patch without its edge, whose colour is mixed."""
    core = opencv().erode(inside.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    return core if core.any() else inside


def clusters(discs: Sequence[Disc]) -> dict[str, tuple[float, float]]:
    """Colours that there are, by the gaps between hues.

    Args:
        discs: Discs of all pictures.

    Returns:
        Lowest and highest hue of each, by its name [deg]; the first may be above the last.
    """
    hues = np.sort([disc.hue for disc in discs])
    if not len(hues):
        return {}
    gaps = np.diff(np.append(hues, hues[0] + 360))
    cuts = np.flatnonzero(gaps > _APART)
    colours: dict[str, tuple[float, float]] = {}
    for place, cut in enumerate(cuts):
        low = hues[(cuts[place - 1] + 1) % len(hues)]
        middle = (low + ((hues[cut] - low) % 360) / 2) % 360
        name, number = _word(middle), 2
        while name in colours:
            name, number = f"{_word(middle)}_{number}", number + 1
        colours[name] = (float(low), float(hues[cut]))
    return colours or {_word(float(hues.mean())): (float(hues[0]), float(hues[-1]))}


def _word(hue: float) -> str:
    """The name of a hue."""
    middles = {}
    for name, colour in WORDS.items():
        low, high = np.degrees(colour.hue)
        middles[name] = (low + ((high - low) % 360) / 2) % 360
    return min(middles, key=lambda name: abs((middles[name] - hue + 180) % 360 - 180))


def has_hue(colour: tuple[float, float], hue: float) -> bool:
    """Whether a hue is within a colour's.

    Args:
        colour: Its lowest and highest hue [deg].
        hue: The hue [deg].

    Returns:
        Whether it is.
    """
    low, high = colour
    return (hue - low) % 360 <= (high - low) % 360 + 1e-9
