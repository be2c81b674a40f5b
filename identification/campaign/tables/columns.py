"""The columns of a stream: their names, the units each may have, and what these mean."""

import dataclasses
import math

import numpy as np
from jaxtyping import Float64

from identification.campaign.types import encoder_resolution


@dataclasses.dataclass(frozen=True)
class Scale:
    """How a written number becomes one in SI units: times `factor` times 10^`exponent`."""

    exponent: int = 0
    """Power of ten, exact in decimal numbers."""
    factor: float = 1.0
    """SI units in one of the rest."""

    def __call__(self, numbers: Float64[np.ndarray, "..."]) -> Float64[np.ndarray, "..."]:
        """Numbers in SI units.

        Args:
            numbers: Numbers in this unit.

        Returns:
            The same in SI units.
        """
        # A division by a power of ten is rounded once, a product with 1e-3 twice.
        if self.exponent < 0:
            return numbers / 10.0**-self.exponent * self.factor
        return numbers * 10.0**self.exponent * self.factor


TIME = {"s": Scale(), "ms": Scale(-3), "us": Scale(-6)}
"""Units of time."""
LENGTH = {"m": Scale(), "cm": Scale(-2), "mm": Scale(-3)}
"""Units of length."""
ANGLE = {"rad": Scale(), "deg": Scale(factor=math.pi / 180)}
"""Units of an angle."""
TURN = {**ANGLE, "rev": Scale(factor=2 * math.pi)}
"""Units of the angle of what turns round."""
VOLTAGE = {"V": Scale(), "mV": Scale(-3)}
"""Units of a voltage."""
CURRENT = {"A": Scale(), "mA": Scale(-3)}
"""Units of a current."""

ACCELERATION = {"m/s^2": Scale(), "mm/s^2": Scale(-3), "g": Scale(factor=9.80665)}
"""Units of an acceleration."""


@dataclasses.dataclass(frozen=True)
class Column:
    """A column that the format knows."""

    name: str
    """Name in the header."""
    units: dict[str, Scale]
    """Units that it may have."""
    partner: str = ""
    """Of an optional column: the one that it comes with, itself if it stands alone."""

    @property
    def header(self) -> str:
        """An example of its header."""
        return f"{self.name} [{next(iter(self.units))}]"

    @property
    def accepted(self) -> str:
        """The units that it may have, as they are listed to people."""
        return ", ".join(f"[{unit}]" for unit in self.units)


CAMERA: tuple[Column, ...] = (
    Column("t", TIME),
    Column("x_e", LENGTH),
    Column("y_e", LENGTH),
    Column("delta_e", ANGLE),
    Column("q_3", LENGTH),
    Column("q_4", LENGTH),
)
"""Columns of `camera.csv`."""

ACCELEROMETER: tuple[Column, ...] = (
    Column("t", TIME),
    Column("a_x", ACCELERATION),
    Column("a_y", ACCELERATION, partner="a_y"),
    Column("a_z", ACCELERATION, partner="a_z"),
)
"""Columns of `accelerometer.csv`."""


def drive_columns(counts_per_rev: float | None) -> tuple[Column, ...]:
    """Columns of `drive.csv`.

    Args:
        counts_per_rev: Encoder counts of one turn of a driver pulley [1], None if unknown.

    Returns:
        The columns; angles may be in counts if the counts of a turn are known.
    """
    angle = TURN
    if counts_per_rev is not None:
        angle = {**TURN, "count": Scale(factor=encoder_resolution(counts_per_rev))}
    return (
        Column("t", TIME),
        Column("voltage_1", VOLTAGE),
        Column("voltage_2", VOLTAGE),
        Column("alpha_1", angle),
        Column("alpha_2", angle),
        Column("current_1", CURRENT, partner="current_2"),
        Column("current_2", CURRENT, partner="current_1"),
        Column("tension", {"N": Scale()}, partner="tension"),
        Column("x_ref", LENGTH, partner="y_ref"),
        Column("y_ref", LENGTH, partner="x_ref"),
    )
