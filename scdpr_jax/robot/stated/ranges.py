"""What a number of a robot can be at most and at least, and robots that can't be.

The ranges are wide: a rig of the palm of a hand and one of a stadium's roof are within them.
What is outside is a slip of the unit or of the file.
"""

import math
from collections.abc import Mapping

from scdpr_jax.robot.stated.names import Quantity, quantity

RANGES: dict[str, tuple[float, float]] = {
    "m": (1e-4, 200.0),
    "kg": (1e-4, 1e4),
    "kg m^2": (1e-9, 1e4),
    "N": (1e-3, 1e6),
    "N m": (1e-12, 1e4),
    "N m s": (1e-12, 1e4),
    "N m/V": (1e-6, 1e4),
    "V": (1e-3, 1e4),
    "N/m": (1e-6, 1e9),
    "N s/m": (1e-12, 1e6),
    "m/s": (1e-6, 100.0),
    "m/N": (1e-12, 1e-2),
    "1": (1e-12, 10.0),
}
"""Least and most of a quantity of each unit; one that may be zero has zero for the least."""

SETTING_TOLERANCE = 0.01
"""Share of a nominal pretension by which a reading of it may be off and is the same setting:
loops are tensioned to a per cent, and settings lie further apart [1]."""


def limits(kind: Quantity) -> tuple[float, float]:
    """What a quantity can be.

    Args:
        kind: The quantity.

    Returns:
        The least and the most [in its unit].
    """
    least, most = RANGES[kind.unit]
    if kind.signed:
        return -most, most
    return (least, most) if kind.positive else (0.0, most)


def check_value(name: str, value: float) -> None:
    """Refuse a number that no robot has.

    Args:
        name: A name of `EVERY_QUANTITY`.
        value: Its value [in the quantity's SI unit].

    Raises:
        ValueError: If the name is unknown, or the number isn't finite or out of its range.
    """
    kind = quantity(name)
    least, most = limits(kind)
    if not (math.isfinite(value) and least <= value <= most):
        unit = "" if kind.unit == "1" else f" {kind.unit}"
        raise ValueError(
            f"`{name}` can't be a robot's, got {value:.6g}{unit}, expected {least:g} to "
            f"{most:g} [{kind.unit}]: the {kind.meaning}. Correct the value, or its unit."
        )


def check_robot(values: Mapping[str, float]) -> None:
    """Refuse numbers that no robot has together.

    Args:
        values: Values [SI] by name; what isn't there isn't checked.

    Raises:
        ValueError: If one is out of its range, or the end-effector or a pulley doesn't fit
            into the frame.
    """
    for name, value in values.items():
        check_value(name, value)
    offsets = ("lower_offset", "upper_offset")
    for parts in (offsets, ("effective_radius",)):
        if not {*parts, "frame_height"} <= values.keys():
            continue
        size = sum(values[part] for part in parts)
        if not size < values["frame_height"]:
            names = " + ".join(f"`{part}`" for part in parts)
            raise ValueError(
                f"{names} can't be a robot's, got {size:.6g} m, expected less than the "
                f"`frame_height` of {values['frame_height']:.6g} m [m]. Correct the values, or "
                "their units."
            )
