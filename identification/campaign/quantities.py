"""Quantities as people write them: a number with its unit, to SI and back.

Units are known to `pint`, which takes half a second to load: what campaigns are mostly
written in is in a table of its own. Numbers are scaled in decimal arithmetic, so that
"26 mm" is the double nearest to 0.026 and not a neighbour.
"""

import functools
import math
import re
from decimal import Decimal
from typing import TYPE_CHECKING

from scdpr_jax.numerics.files.harmless import represented

if TYPE_CHECKING:
    import pint

_NUMBER = re.compile(
    r"\s*(?P<number>[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|nan|inf(?:inity)?))"
    r"(?![.,\d])\s*(?P<unit>.*)",
    re.ASCII | re.IGNORECASE | re.DOTALL,
)
# A product of powers of unit symbols. What pint's own, wider grammar takes beyond it
# (sums, numbers, brackets) is no unit, and not all of it fails with pint's own errors.
# Both are bounded: what people write is short, and pint takes seconds for what is long.
_POWER = r"(?:[A-Za-zµμΩÅ]{1,24}|[%°])(?:(?:\^|\*\*)[+-]?\d|⁻?[¹²³⁴⁵⁶⁷⁸⁹])?"
_PRODUCT = re.compile(rf"(?:1\s*/\s*)?{_POWER}(?:(?:\s*[·⋅*/]\s*|\s+){_POWER}){{0,5}}")
_LONGEST = 80
"""Characters of a quantity."""
LARGEST = 1e30
"""Largest number of anything that is read [SI]; the fourth power of it is still one."""


EVERYDAY: dict[tuple[str, str], Decimal] = {
    ("mm", "m"): Decimal("1e-3"),
    ("cm", "m"): Decimal("1e-2"),
    ("ms", "s"): Decimal("1e-3"),
    ("us", "s"): Decimal("1e-6"),
    ("mrad", "rad"): Decimal("1e-3"),
    ("mV", "V"): Decimal("1e-3"),
    ("kN", "N"): Decimal("1e3"),
    ("g", "kg"): Decimal("1e-3"),
    ("%", "1"): Decimal("1e-2"),
}
"""Factors of the units that campaigns are mostly written in, as `pint` has them."""


class QuantityError(ValueError):
    """A text that isn't the quantity asked for; its message has all five parts."""

    def __init__(self, problem: str, *, name: str, got: str, expected: str, remedy: str):
        self.problem = problem
        """What is wrong with it."""
        self.name = name
        """Which quantity, or where it stands."""
        self.got = got
        """What was found, as it was written."""
        self.expected = expected
        """What was expected, with the unit."""
        self.remedy = remedy
        """What to do."""
        super().__init__(f"`{name}`: {problem}, got {got}, expected {expected}. {remedy}")


def parse_quantity(text: str, *, unit: str, name: str = "quantity") -> float:
    """The value of a written quantity in SI units.

    Args:
        text: A number with its unit, like "35.1507 N/V", "0.2 N·m·s" or "26 mm"; without
            one, or in percent, where the unit is "1". Case is SI's.
        unit: SI unit of the result, "1" for none.
        name: What the quantity is, or where it stands, for the message.

    Returns:
        The value [in `unit`].

    Raises:
        QuantityError: If the text is no number with a unit, isn't finite, or has a unit of
            another dimension; a `ValueError`.
    """
    if len(text) > _LONGEST:
        raise _fault(f"a text of {len(text)} characters, no quantity", text, unit, name)
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise _fault("not a quantity", text, unit, name)
    number, written = match["number"], match["unit"].strip()
    if not written and unit != "1":
        raise _fault("a number without its unit", text, unit, name, example=number)
    factor = _factor(text, written or "1", unit, name)
    value = _scaled(number, factor)
    if not math.isfinite(value):
        raise _fault("not finite", text, unit, name)
    if abs(value) > LARGEST:
        raise _fault("a number that nothing of a rig has", text, unit, name)
    return value


def format_quantity(value: float, unit: str) -> str:
    """A value with its unit, which `parse_quantity` reads back exactly.

    Args:
        value: The value [in `unit`].
        unit: SI unit, "1" for none.

    Returns:
        The shortest decimal number that is this double, and the unit: "350 N", "0.018".

    Raises:
        ValueError: If the value isn't finite.
    """
    if not math.isfinite(value):
        raise ValueError(
            f"a quantity to be written must be finite [{unit}], got {value}. "
            "Leave out what isn't known."
        )
    number = repr(float(value)).removesuffix(".0")
    return number if unit == "1" else f"{number} {unit}"


def _scaled(number: str, factor: Decimal) -> float:
    value = float(number)
    # Nothing to scale, and exponents beyond the decimals' range end here.
    if factor == 1 or value == 0 or not math.isfinite(value):
        return value
    return float(Decimal(number) * factor)


def _fault(
    problem: str, text: str, unit: str, name: str, *, example: str = "0.5"
) -> QuantityError:
    expected = "a number [1], or one in %" if unit == "1" else f"a number and its unit [{unit}]"
    whole = example if unit == "1" else f"{example} {unit}"
    return QuantityError(
        problem,
        name=name,
        got=represented(text),
        expected=expected,
        remedy=f'Write it like "{whole}"; a product of units has a space or a dot: "N m".',
    )


def _factor(text: str, written: str, unit: str, name: str) -> Decimal:
    if written != "1" and _PRODUCT.fullmatch(written) is None:
        raise _fault(f"{written!r} is no unit", text, unit, name)
    factor = _conversion(written, unit)
    if factor is None:
        raise _fault(f"{written!r} is no unit of the right dimension", text, unit, name)
    return factor


@functools.cache
def _registry() -> "pint.UnitRegistry":
    import pint

    registry = pint.UnitRegistry(non_int_type=Decimal)
    registry.define("@alias turn = rev")
    return registry


@functools.lru_cache(4096)
def _conversion(written: str, unit: str) -> Decimal | None:
    """Factor from a written unit to another one, None if there is none."""
    if written == unit:
        return Decimal(1)
    if (written, unit) in EVERYDAY:
        return EVERYDAY[written, unit]
    return _pint_conversion(written, unit)


def _pint_conversion(written: str, unit: str) -> Decimal | None:
    """The same for any unit."""
    import pint

    registry = _registry()
    expected = registry.parse_units(unit)
    try:
        got = registry.parse_units(written)
        # Degrees Celsius and decibels are no factors: their products raise.
        registry.Quantity(Decimal(1), got) * registry.Quantity(Decimal(1), expected)
        got_factor, got_root = registry.get_root_units(got)
    except (pint.errors.PintError, ValueError, ArithmeticError):
        # A name that is a number to pint's own reader, or a power beyond its decimals.
        return None
    if got.dimensionality != expected.dimensionality:
        return None
    expected_factor, expected_root = registry.get_root_units(expected)
    # To pint an angle has no dimension, so it would take 2 Hz for 2 rad/s and 3 for 3 rad.
    # Torques and their ratios are written with and without "rad" and mean the same.
    if "[mass]" not in expected.dimensionality and got_root != expected_root:
        return None
    return Decimal(got_factor) / Decimal(expected_factor)
