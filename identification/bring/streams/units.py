"""Units of a log's channels, as its maker wrote them, to SI."""

from identification.campaign.quantities import QuantityError, parse_quantity
from identification.campaign.tables.columns import Column, Scale

UTC = "UTC"
"""What stands for a unit where a channel's cells are dates and times."""

ALIASES = {
    "°": "deg",
    "degree": "deg",
    "degrees": "deg",
    "grad": "deg",
    "radian": "rad",
    "radians": "rad",
    "turn": "rev",
    "turns": "rev",
    "revs": "rev",
    "u": "rev",
    "counts": "count",
    "cts": "count",
    "cnt": "count",
    "inc": "count",
    "incr": "count",
    "increments": "count",
    "ticks": "count",
    "tick": "count",
    "pulses": "count",
    "sec": "s",
    "secs": "s",
    "second": "s",
    "seconds": "s",
    "msec": "ms",
    "millisecond": "ms",
    "milliseconds": "ms",
    "µs": "us",
    "μs": "us",
    "usec": "us",
    "microseconds": "us",
    "volt": "V",
    "volts": "V",
    "millivolt": "mV",
    "ampere": "A",
    "amps": "A",
    "newton": "N",
    "meter": "m",
    "meters": "m",
    "metre": "m",
    "metres": "m",
    "millimeter": "mm",
    "millimeters": "mm",
    "millimetre": "mm",
    "millimetres": "mm",
    "centimeter": "cm",
    "centimeters": "cm",
    "m/s²": "m/s^2",
    "m/s2": "m/s^2",
    "m/s/s": "m/s^2",
    "mm/s²": "mm/s^2",
    "mm/s2": "mm/s^2",
}
"""Other ways to write the units of the format, in lower case."""


def unit_scale(column: Column, unit: str) -> Scale | None:
    """What numbers in a unit become SI units by.

    Args:
        column: The column of the format that they are.
        unit: The unit as somebody wrote it.

    Returns:
        The scale, None where it is no unit of this column.
    """
    text = unit.strip()
    for name in (text, ALIASES.get(text.lower(), text)):
        if name in column.units:
            return column.units[name]
    si = next(iter(column.units))
    try:
        return Scale(factor=parse_quantity(f"1 {text}", unit=si))
    except QuantityError:
        return None
