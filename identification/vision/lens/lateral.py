r"""Lateral colour: a lens magnifies each colour by another factor.

At a picture's edge blue is seen a tenth of a pixel or two farther in than red. Discs of
different colours are measured by the same luma, so they are shifted against each other, by
what their own mixture of colours makes of it. The photos of the board tell it: along its
edges the blue channel is the red one shifted,
$B(p) = g R(p) + o - g\,c\,(p - p_0) \cdot \nabla R$,
where $g$ and $o$ are the white balance's. Corners of each channel would be simpler, but half
of the pixels' chroma blurs what they are found by, and most of the difference with it; a
shift's first moment survives any blur.
"""

import colorsys
import math

import numpy as np
from jaxtyping import Float32, Float64, UInt8

from identification.vision.pictures.opencv import opencv
from identification.vision.settings.document import Colour

_BLUR = 2.5
_LUMA = np.array([0.299, 0.587, 0.114])
_RED_GREEN_BLUE = np.array([-0.5, 0.0, 0.5])
_TYPICAL = (0.85, 0.7)


def blue_less_red(
    photo: UInt8[np.ndarray, "height width 3"],
    corners: Float32[np.ndarray, "corners 1 2"],
    principal: Float64[np.ndarray, " 2"],
) -> float:
    """How much more blue is magnified than red, by one photo of a board.

    Args:
        photo: The photo, BGR.
        corners: The board's inner corners in it [px].
        principal: Principal point [px].

    Returns:
        The difference of the magnifications [1].
    """
    cv2 = opencv()
    low = np.floor(corners.reshape(-1, 2).min(axis=0)).astype(int)
    high = np.ceil(corners.reshape(-1, 2).max(axis=0)).astype(int)
    patch = photo[low[1] : high[1], low[0] : high[0]].astype(np.float32)
    blue, _, red = np.moveaxis(cv2.GaussianBlur(patch, (0, 0), _BLUR), -1, 0)
    mask = np.zeros(red.shape, np.uint8)
    hull = cv2.convexHull(corners.reshape(-1, 1, 2)) - low.astype(np.float32)
    cv2.fillConvexPoly(mask, hull.astype(np.int32), 1)
    slope_v, slope_u = np.gradient(red)
    v, u = np.nonzero(mask)
    along = (u + low[0] - principal[0]) * slope_u[v, u] + (v + low[1] - principal[1]) * slope_v[
        v, u
    ]
    columns = np.stack(
        [red[v, u], np.ones(len(u)), -along, -slope_u[v, u], -slope_v[v, u]], axis=-1
    ).astype(float)
    fit = np.linalg.lstsq(columns, blue[v, u].astype(float), rcond=None)[0]
    return float(fit[2] / fit[0])


def magnification(colour: Colour, lateral: float) -> float:
    """By how much a disc of a colour is magnified more than a grey one.

    Args:
        colour: The colour.
        lateral: How much more blue is magnified than red [1].

    Returns:
        The difference [1].
    """
    low, high = colour.hue
    hue = (low + ((high - low) % (2 * math.pi)) / 2) / (2 * math.pi) % 1
    light = _LUMA * np.array(colorsys.hsv_to_rgb(hue, *_TYPICAL))
    return float(lateral * (light @ _RED_GREEN_BLUE) / light.sum())
