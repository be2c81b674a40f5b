r"""One coloured disc in a picture, by its shape.

What is known of a disc is much: where it about is, its diameter, how the camera sees a piece
of the plane there, how far it moves during the exposure. So its picture is known but for its
place, and the place is what makes the sum over pixels of
$w_k (a_k - b - c\,m_k(u, v, \rho))^2$ least: $a_k$ is the share of pixel $k$ that is the
disc's colour, $m_k$ the share that a disc of centre $(u, v)$ and relative radius $\rho$
covers, blurred by the lens and by its motion. The centroid of the disc's colour would be
simpler, and takes in whatever of like colour is near, and what an arm before the disc leaves
of it; here pixels of a third colour, and those that disagree, have no weight.

Shares are told by the luma, through the colours of the disc and of what is around it, in linear
light. The chroma of most videos has half of the pixels, and is shifted by up to 0.1 px,
by each program in its own way.
"""

import dataclasses
import functools
import math

import numpy as np
from jaxtyping import Bool, Float64, UInt8
from scipy.special import ndtr

LUMA = np.array([0.114, 0.587, 0.299])
"""Weights of blue, green and red in the luma that videos keep at full resolution."""
_LEVELS = np.arange(256) / 255
LINEAR = np.where(_LEVELS <= 0.04045, _LEVELS / 12.92, ((_LEVELS + 0.055) / 1.055) ** 2.4)
"""Light of each level, of sRGB [1]."""
_SHARES = np.linspace(-0.25, 1.5, 176)
_ROUNDS = 5  # it is there after three, where its colours were right
_OFF_COLOUR = 0.35  # of the colours' distance; JPEG's chroma is off by up to 0.3
_OFF_COLOUR_EDGE = 0.6  # where half of the chroma is the neighbours'
_EDGE = 4e-3  # share at which a pixel is the edge's
_FEW = 8  # pixels
_INSIDE = 0.6  # share of the disc's own light
_RIM = 4.5  # blurs
_LIMIT = 0.35  # share: noise has 0.1, another thing 0.5 and more
_MARGIN = 2.6  # blurs: 1 % of the edge's light is farther out
_CLOSE = 3e-3  # px
_LEAST_AMPLITUDE = 0.2
_PAIRS = 6
"""Pairs of opposite pieces of a disc's edge that are off independently of each other."""
_OF_PAIRS = 1.5  # a fit leaves less of their pulls than there was
_SQRT_TAU = np.sqrt(2 * np.pi)


@dataclasses.dataclass(frozen=True)
class Shape:
    """What is known of a disc's picture but for its place."""

    axes: Float64[np.ndarray, "2 2"]
    """Pixels for one radius along x and along y, as columns [px]."""
    blur: float
    """Standard deviation of the lens's and the sensor's blur [px]."""
    travel: Float64[np.ndarray, " 2"]
    """Path during the exposure [px]."""

    @property
    def radius(self) -> float:
        """Radius of the circle with its area [px]."""
        (a, b), (c, d) = self.axes.tolist()
        return math.sqrt(abs(a * d - b * c))

    @functools.cached_property
    def inverse(self) -> Float64[np.ndarray, "2 2"]:
        """Radii over the blur for a pixel along u and along v [1/px]."""
        return np.linalg.inv(self.axes) / self.blur


@dataclasses.dataclass(frozen=True)
class Disc:
    """A disc as it was measured."""

    centre: Float64[np.ndarray, " 2"]
    """Centroid of its picture [px]."""
    scale: float
    """Radius over the one that was expected [1]."""
    hidden: float
    """Share of its area that isn't its colour [1]."""
    misfit: float
    """Root mean square of the pixels' shares about the fit [1]."""
    colour: Float64[np.ndarray, " 3"]
    """Its colour in linear light, BGR [1]."""
    variance: Float64[np.ndarray, " 2"]
    """Of its centre's coordinates, by what the pixels are off by, see `_variance` [px²]."""


def measure(
    picture: UInt8[np.ndarray, "height width 3"],
    near: Float64[np.ndarray, " 2"],
    shape: Shape,
) -> Disc | None:
    """Measure a disc.

    Args:
        picture: The picture, BGR.
        near: Where it is, to a third of its radius [px].
        shape: Its shape.

    Returns:
        The disc; None if it reaches over the picture's edge or isn't there at all.
    """
    window = _window(picture.shape, near, shape)
    if window is None:
        return None
    rows, columns = window
    patch = picture[rows, columns].reshape(-1, 3)
    y, x = (each.ravel().astype(float) for each in np.mgrid[rows, columns])
    light, luma = LINEAR[patch], patch @ LUMA
    centre, scale = np.array(near, float), 1.0
    weight, fitted = np.ones(len(luma)), None
    for turn in range(_ROUNDS):
        cover, slopes, reach, rim = _coverage(x - centre[0], y - centre[1], scale, shape)
        if turn in (0, 1, 3):
            colours = _colours(light, cover, rim, weight)
            if colours is None:
                return None
            share, off = _shares(light, luma, *colours)
        model = np.stack((*slopes, cover, np.ones(len(cover))))
        weight = (~_other_colour(off, cover)).astype(float)
        if fitted is not None:
            weight *= np.clip(1.5 - np.abs(share - fitted) / _LIMIT, 0, 1)
        scaled = model * (weight * reach)
        step = np.linalg.solve(scaled @ model.T + 1e-9 * np.eye(5), scaled @ share)
        fitted = step @ model
        move = step[:3] / max(step[3], _LEAST_AMPLITUDE)
        most = 0.5 * shape.radius
        centre = centre + np.clip(move[:2], -most, most)
        scale = float(np.clip(scale + move[2], 0.5, 1.6))
        if np.abs(centre - near).max() > shape.radius:
            return None
        if turn > 1 and np.abs(move[:2]).max() < _CLOSE:
            break
    angle = np.arctan2(y - centre[1], x - centre[0])
    path = math.atan2(*shape.travel[::-1])
    unit = _variance(model, scaled, share - fitted, angle - path, path)
    variance = unit / max(step[3], _LEAST_AMPLITUDE) ** 2
    return _judged(share, fitted, off, cover, reach, centre, scale, colours, variance)


def _variance(
    model: Float64[np.ndarray, "5 pixels"],
    scaled: Float64[np.ndarray, "5 pixels"],
    error: Float64[np.ndarray, " pixels"],
    angle: Float64[np.ndarray, " pixels"],
    path: float,
) -> Float64[np.ndarray, " 2"]:
    """Variance of a disc's place by what its pixels are off by.

    Neighbouring pixels are off together: a Bayer pattern's colours and a codec's blocks are
    interpolated over several. So the pull of each piece of the edge is taken as a whole, with
    that of the piece across: what a blur or a path is off by does the same to both, and moves
    nothing. What an acceleration does moves the disc along its path alone, so across it the
    pieces on both of its sides go together. To take the pixels for independent would be
    simpler, and says half of it.
    """
    pair = np.floor(angle * (_PAIRS / np.pi)).astype(int) % _PAIRS
    pulls = np.stack([np.bincount(pair, row, _PAIRS) for row in scaled * error])
    moved = np.linalg.solve(scaled @ model.T + 1e-9 * np.eye(5), pulls)[:2]
    turn = np.array([[math.cos(path), math.sin(path)], [-math.sin(path), math.cos(path)]])
    along, across = turn @ moved
    across = across[: _PAIRS // 2] + across[: _PAIRS // 2 - 1 : -1]
    squares = np.array([along @ along, across @ across])
    return _OF_PAIRS * (turn.T**2 @ squares)


def _judged(
    share: Float64[np.ndarray, " pixels"],
    fitted: Float64[np.ndarray, " pixels"],
    off: Float64[np.ndarray, " pixels"],
    cover: Float64[np.ndarray, " pixels"],
    reach: Bool[np.ndarray, " pixels"],
    centre: Float64[np.ndarray, " 2"],
    scale: float,
    colours: tuple[Float64[np.ndarray, " 3"], Float64[np.ndarray, " 3"]],
    variance: Float64[np.ndarray, " 2"],
) -> Disc:
    """What the last round found."""
    error = share - fitted
    other = _other_colour(off, cover) | (np.abs(error) > _LIMIT)
    # At the rim of a fast disc what is behind its plate shows through, which hides nothing.
    inside = cover * (cover > _INSIDE * cover.max())
    hidden = float((inside * other).sum() / inside.sum())
    good = reach & ~other
    misfit = float(np.sqrt((error[good] ** 2).mean())) if good.any() else np.inf
    return Disc(centre, scale, hidden, misfit, colours[0], variance)


def _other_colour(
    off: Float64[np.ndarray, " pixels"], cover: Float64[np.ndarray, " pixels"]
) -> Bool[np.ndarray, " pixels"]:
    """Which pixels have a third colour; at the edge half of the chroma is the neighbours'."""
    at_edge = (cover > _EDGE) & (cover < 1 - _EDGE)
    return off > np.where(at_edge, _OFF_COLOUR_EDGE, _OFF_COLOUR)


def _window(
    size: tuple[int, ...], near: Float64[np.ndarray, " 2"], shape: Shape
) -> tuple[slice, slice] | None:
    half = np.sqrt((shape.axes**2).sum(axis=1)) * 1.1
    half = half + np.abs(shape.travel) / 2 + _RIM * shape.blur
    low = np.floor(near - half).astype(int)
    high = np.ceil(near + half).astype(int) + 1
    if (low < 0).any() or high[1] > size[0] or high[0] > size[1]:
        return None
    return slice(low[1], high[1]), slice(low[0], high[0])


def _coverage(
    x: Float64[np.ndarray, " pixels"],
    y: Float64[np.ndarray, " pixels"],
    scale: float,
    shape: Shape,
) -> tuple[
    Float64[np.ndarray, " pixels"],
    tuple[Float64[np.ndarray, " pixels"], ...],
    Bool[np.ndarray, " pixels"],
    Bool[np.ndarray, " pixels"],
]:
    """Share of each pixel that is the disc's, its slopes, where it tells anything, and the rim.

    The edge is a straight one to each pixel, as the blur is short beside the radius.
    """
    count = max(1, int(np.ceil(np.hypot(*shape.travel) / (2 * shape.blur))))
    (a, b), (c, d) = shape.inverse.tolist()
    total = np.zeros((4, len(x)))
    for share in (np.arange(count) + 0.5) / count - 0.5:
        dx, dy = x - share * shape.travel[0], y - share * shape.travel[1]
        # In radii over the blur: the edge is where the length is 1 / blur.
        p, q = a * dx + b * dy, c * dx + d * dy
        length = np.sqrt(p * p + q * q) + 1e-12
        along_x, along_y = a * p + c * q, b * p + d * q
        # In the very middle no direction leads to the edge.
        steep = np.maximum(np.sqrt(along_x * along_x + along_y * along_y) / length, 1e-9)
        inside = (scale / shape.blur - length) / (steep * shape.blur)
        bell = np.exp(-0.5 * inside * inside) / steep
        total[0] += ndtr(inside)
        total[1] += bell / length * along_x
        total[2] += bell / length * along_y
        total[3] += bell
    total[1:] /= _SQRT_TAU * shape.blur
    total[3] /= shape.blur
    total /= count
    cover, *slopes = total
    # How near the edge is, by the bell: it says so for a disc that moves, too.
    edge = slopes[2] * (_SQRT_TAU * shape.blur * count * 1 / shape.radius)
    reach = (cover > 0.5) | (edge > np.exp(-0.5 * _MARGIN**2))
    rim = ~reach & (edge > np.exp(-0.5 * _RIM**2))
    return cover, tuple(slopes), reach, rim


def _colours(
    light: Float64[np.ndarray, "pixels 3"],
    cover: Float64[np.ndarray, " pixels"],
    rim: Bool[np.ndarray, " pixels"],
    weight: Float64[np.ndarray, " pixels"],
) -> tuple[Float64[np.ndarray, " 3"], Float64[np.ndarray, " 3"]] | None:
    """Light of the disc and of the rim around it."""
    inner = (cover > 0.97) & (weight > 0.5)
    if np.count_nonzero(inner) < _FEW:
        inner = cover > 0.9 * cover.max()
    outer = rim & (weight > 0.5)
    if np.count_nonzero(outer) < _FEW:
        outer = rim
    if not inner.any() or np.count_nonzero(outer) < _FEW:
        return None
    disc, ground = _centre_of(light[inner]), _most_common(light[outer])
    return (disc, ground) if np.linalg.norm(disc - ground) > 0.02 else None


def _centre_of(light: Float64[np.ndarray, "pixels 3"]) -> Float64[np.ndarray, " 3"]:
    """Mean of the middle half of each channel: levels are whole numbers, a median is one."""
    ordered = np.sort(light, axis=0)
    quarter = len(light) // 4
    return ordered[quarter : len(light) - quarter].mean(axis=0)


def _most_common(light: Float64[np.ndarray, "pixels 3"]) -> Float64[np.ndarray, " 3"]:
    """Mean of the pixels about the median: what is beside the plate isn't the ground."""
    apart = np.abs(light - _median(light)).sum(axis=1)
    return light[apart <= _median(apart) + 1e-4].mean(axis=0)


def _median(values: Float64[np.ndarray, "..."]) -> Float64[np.ndarray, "..."] | float:
    """The median over pixels; of a few hundred, NumPy's own takes five times as long."""
    ordered, half = np.sort(values, axis=0), len(values) // 2
    return ordered[half] if len(values) % 2 else (ordered[half - 1] + ordered[half]) / 2


def _shares(
    light: Float64[np.ndarray, "pixels 3"],
    luma: Float64[np.ndarray, " pixels"],
    disc: Float64[np.ndarray, " 3"],
    ground: Float64[np.ndarray, " 3"],
) -> tuple[Float64[np.ndarray, " pixels"], Float64[np.ndarray, " pixels"]]:
    """Share of each pixel that is the disc's, and how far its colour is off the line."""
    difference = disc - ground
    square = difference @ difference
    apart = light - ground
    along = np.clip(apart @ difference / square, 0, 1)
    off = np.sqrt(((apart - along[..., None] * difference) ** 2).sum(axis=-1) / square)
    mixed = np.clip(ground + _SHARES[:, None] * difference, 0, 1)
    levels = stored(mixed) @ LUMA
    if levels[-1] < levels[0]:
        share = np.interp(luma, levels[::-1], _SHARES[::-1])
    else:
        share = np.interp(luma, levels, _SHARES)
    return share, off


def stored(light: Float64[np.ndarray, "*many 3"]) -> Float64[np.ndarray, "*many 3"]:
    """Levels that light is stored as.

    Args:
        light: Light [1].

    Returns:
        Levels of sRGB, not rounded.
    """
    curved = 1.055 * np.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055
    return 255 * np.where(light <= 0.0031308, 12.92 * light, curved)
