"""Colours of the pages: one name for each, and what it is by day and by night.

A figure is drawn by day; `themed` turns its colours into the page's names, so that it is seen
by night as well.
"""

import re
from typing import NamedTuple


class Shade(NamedTuple):
    """A colour of the pages."""

    name: str
    """Its name in the style sheet."""
    day: str
    """What it is on white."""
    night: str
    """What it is where the reader prefers dark."""


INK, SOFT = Shade("ink", "#1a1a1a", "#e8eaec"), Shade("soft", "#59636e", "#a9b1b9")
PAPER, PANEL = Shade("paper", "#ffffff", "#16191c"), Shade("panel", "#f5f7f9", "#1f2428")
LINE = Shade("line", "#d5dae0", "#3a4148")
GOOD, CARE = Shade("good", "#00664a", "#4fd0a5"), Shade("care", "#7a5200", "#f0b849")
BAD = Shade("bad", "#a33f00", "#ff9a5c")

TEXTS: tuple[Shade, ...] = (INK, SOFT, GOOD, CARE, BAD)
"""What words are written in, on `PAPER` and on `PANEL`."""

GREY, GRID = Shade("d-grey", "#6e6e6e", "#a9b1b9"), Shade("d-grid", "#e3e3e3", "#343a41")
ORANGE, SKY = Shade("d-orange", "#e69f00", "#f2b533"), Shade("d-sky", "#56b4e9", "#7cc8f2")
GREEN, BLUE = Shade("d-green", "#009e73", "#3ccba0"), Shade("d-blue", "#0072b2", "#4aa8e8")
VERMILION = Shade("d-red", "#d55e00", "#ff8a3d")
PURPLE = Shade("d-purple", "#cc79a7", "#e39ac4")
RED_WORDS = Shade("d-word", "#b04a00", "#ff9a5c")
"""Vermilion for words, which need more contrast than lines."""

DRAWN: tuple[Shade, ...] = (
    GREY,
    GRID,
    Shade("d-band", "#ececec", "#2b3036"),
    Shade("d-steel", "#d9d9d9", "#4a5158"),
    Shade("d-body", "#cfe3f1", "#28455c"),
    ORANGE,
    SKY,
    GREEN,
    BLUE,
    VERMILION,
    PURPLE,
    RED_WORDS,
)
"""What lines and areas of figures are drawn in: the palette of Okabe and Ito, which the
colour-blind can tell apart, and greys."""

SHADES: tuple[Shade, ...] = (*TEXTS, PAPER, PANEL, LINE, *DRAWN)
"""Every colour that changes between day and night."""

_VARIABLES = {shade.day: f"var(--{shade.name})" for shade in (INK, PAPER, *DRAWN)}
_COLOUR = re.compile(r"(?<=: )#[0-9a-f]{6}(?=[;\"])")


def themed(svg: str) -> str:
    """A drawing whose colours are those that the page has, by day or by night.

    Args:
        svg: The drawing, with the colours of the day in its style attributes.

    Returns:
        The same with the style sheet's names; a colour without a name stays.
    """
    return _COLOUR.sub(lambda found: _VARIABLES.get(found[0], found[0]), svg)


def declarations(*, night: bool) -> str:
    """The colours as the style sheet declares them.

    Args:
        night: Whether those of the night.

    Returns:
        CSS, "--ink: #1a1a1a; …".
    """
    return " ".join(f"--{s.name}: {s.night if night else s.day};" for s in SHADES)


def contrast(first: str, second: str) -> float:
    """Contrast of two colours, WCAG 2's: 4.5 is asked for words, 3 for lines.

    Args:
        first: A colour, "#rrggbb".
        second: The other one.

    Returns:
        From 1 to 21 [1].
    """
    low, high = sorted((_luminance(first), _luminance(second)))
    return (high + 0.05) / (low + 0.05)


def _luminance(colour: str) -> float:
    """Relative luminance of an sRGB colour."""
    parts = (int(colour[place : place + 2], 16) / 255 for place in (1, 3, 5))
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
