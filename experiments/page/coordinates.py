"""How the measured quantities are shown: symbol, unit to read, factor from SI."""

from typing import NamedTuple

import numpy as np

from experiments.page.theme import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION


class Coordinate(NamedTuple):
    """A measured quantity on a figure or in a table."""

    name: str
    """Column's name, see `identification.fit.comparison`."""
    symbol: str
    """Symbol in plain text."""
    unit: str
    """Unit that it is read in."""
    factor: float
    """What an SI value is multiplied with [unit / SI unit]."""
    color: str
    """Its colour in every figure."""
    marker: str
    """Its marker, which tells it apart without colour."""
    meaning: str
    """What it is."""


CAMERA: tuple[Coordinate, ...] = (
    Coordinate("x_e", "xₑ", "mm", 1e3, BLUE.day, "o", "end-effector, horizontal"),
    Coordinate("delta_e", "δₑ", "°", 180 / np.pi, VERMILION.day, "^", "end-effector, rotation"),
    Coordinate("q_3", "q₃", "mm", 1e3, GREEN.day, "s", "lower carriage"),
    Coordinate("q_4", "q₄", "mm", 1e3, PURPLE.day, "D", "upper carriage"),
    Coordinate("y_e", "yₑ", "mm", 1e3, ORANGE.day, "v", "end-effector, vertical"),
)
"""What the camera sees, in the order of the model's coordinates."""

ENCODERS: tuple[Coordinate, ...] = (
    Coordinate("alpha_1", "α₁", "°", 180 / np.pi, BLUE.day, "o", "driver pulley 1"),
    Coordinate("alpha_2", "α₂", "°", 180 / np.pi, SKY.day, "s", "driver pulley 2"),
)
"""What the encoders see."""

COORDINATES: dict[str, Coordinate] = {c.name: c for c in (*CAMERA, *ENCODERS)}
"""Every measured quantity by its name."""

_GREEK = {
    r"\Delta": "Δ",
    r"\mu": "μ",
    r"\tau": "τ",
    r"\alpha": "α",
    r"\delta": "δ",
    r"\zeta": "ζ",
    r"\omega": "ω",
    r"\varphi": "φ",
}


def plain_symbol(tex: str) -> tuple[str, str]:
    r"""A symbol in TeX as plain text and its index, to be set lower.

    Args:
        tex: The symbol, such as `\tau_f`.

    Returns:
        Base and index; the index is empty where there is none.
    """
    for command, letter in _GREEK.items():
        tex = tex.replace(command, letter)
    base, _, index = tex.partition("_")
    return base, index.strip("{}")
