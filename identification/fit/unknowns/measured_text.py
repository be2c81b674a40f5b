"""What was measured otherwise, as people write it: "drive_friction = 0.2 N m +- 0.1 N m"."""

import difflib
import re

from identification.campaign.quantities import format_quantity, parse_quantity
from identification.fit.unknowns.measured import (
    Measured,
    MeasuredBreakaway,
    MeasuredFrequency,
    MeasuredQuantity,
)
from identification.fit.unknowns.unknowns import PER_SETTING
from scdpr_jax.numerics.files.harmless import represented
from scdpr_jax.robot.quantities import EVERY_QUANTITY, quantity

FREQUENCY, BREAKAWAY = "natural_frequency", "breakaway_voltage"
"""Names of what isn't a quantity of the robot itself."""

_GRAMMAR = re.compile(
    r"\s*(?P<name>\w+)\s*=\s*(?P<value>[^=]+?)\s*(?:\+-|\+/-|±)\s*(?P<sigma>[^=]+?)"
    r"(?:\s+at\s+(?P<places>.+?))?\s*"
)
_LONGEST = 300
_EXAMPLES = (
    '"drive_friction = 0.2 N m +- 0.1 N m", '
    f'"{PER_SETTING} = 71 N +- 2 N at 350 N", '
    f'"{BREAKAWAY} = 1.8 V +- 0.2 V at 350 N" or '
    f'"{FREQUENCY} = 3.2 Hz +- 0.02 Hz at 350 N, 0.55 m"'
)


def parse_measured(text: str) -> Measured:
    """What was measured otherwise, from how people write it.

    Args:
        text: `NAME = VALUE +- STANDARD ERROR`, with units, and where it belongs to a nominal
            pretension ` at PRETENSION`; for a natural frequency, which is that of the sway
            with both carriages held, ` at PRETENSION, HEIGHT`.

    Returns:
        What was measured.

    Raises:
        ValueError: If the text isn't that.
    """
    match = _GRAMMAR.fullmatch(text) if len(text) <= _LONGEST else None
    if match is None:
        raise _fault("can't be read", text)
    name, places = match["name"], [p for p in (match["places"] or "").split(",") if p.strip()]
    unit, count = _expected(name, text)
    if len(places) != count:
        expected = ("nothing", "a pretension", "a pretension and a height")[count]
        raise _fault(f"needs {expected} after `at`", text)
    number, sigma = (
        parse_quantity(match[part], unit=unit, name=f"{part} of {name}")
        for part in ("value", "sigma")
    )
    setting = None
    if places:
        nominal = parse_quantity(places[0], unit="N", name=f"pretension of {name}")
        setting = format_quantity(nominal, "N")
    if name == FREQUENCY:
        height = parse_quantity(places[1], unit="m", name=f"height of {name}")
        return MeasuredFrequency(value=number, sigma=sigma, setting=setting, height=height)
    if name == BREAKAWAY:
        return MeasuredBreakaway(value=number, sigma=sigma, setting=setting)
    return MeasuredQuantity(quantity=name, value=number, sigma=sigma, setting=setting)


def _expected(name: str, text: str) -> tuple[str, int]:
    """Unit of what has a name, and how many places it is measured at."""
    if name == FREQUENCY:
        return "Hz", 2
    if name == BREAKAWAY:
        return "V", 1
    names = [kind.name for kind in EVERY_QUANTITY]
    if name not in names:
        near = difflib.get_close_matches(name, [*names, FREQUENCY, BREAKAWAY], n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        raise _fault(f"names no quantity{hint}", text)
    return quantity(name).unit, int(name == PER_SETTING)


def _fault(problem: str, text: str) -> ValueError:
    return ValueError(
        f"`measured`: what was measured {problem}, got {represented(text)}, expected NAME = "
        f"VALUE +- STANDARD ERROR with units. Write it like {_EXAMPLES}."
    )
