"""Numbers as they are printed: no more digits than their uncertainty bears."""

import math

_MOST_DECIMALS = 12
_MOST_ZEROS = 6
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def decimals(sigma: float) -> int:
    """Decimals that a value deserves: two significant digits of its standard error.

    Args:
        sigma: Standard error, positive.

    Returns:
        Number of decimals, from 0 to 12.
    """
    return min(max(1 - math.floor(math.log10(sigma)), 0), _MOST_DECIMALS)


def rounded(value: float, sigma: float) -> str:
    """A value with the digits that its standard error bears.

    Args:
        value: The value.
        sigma: Its standard error, in the same unit; 0 or infinite for none.

    Returns:
        The number: to two digits of the error, or to six digits of its own.
    """
    if not math.isfinite(value):
        return "∞" if value > 0 else "−∞" if value < 0 else "–"
    if not (sigma > 0 and math.isfinite(sigma)):
        return short(value)
    places = decimals(sigma)
    if abs(value) < 1e-9 and sigma < 1e-9:
        return short(value, 4)
    return _minus(_without_sign_of_zero(f"{value:.{places}f}"))


def short(value: float, digits: int = 6) -> str:
    """A value to some digits, without trailing zeros.

    Args:
        value: The value.
        digits: Significant digits.

    Returns:
        The number; "7.4·10⁻⁷" for one that is very small, or far beyond its digits.
    """
    if not math.isfinite(value):
        return "∞" if value > 0 else "−∞" if value < 0 else "–"
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    if exponent and 0 < int(exponent) <= _MOST_ZEROS:
        mantissa, exponent = f"{float(mantissa) * 10 ** int(exponent):.0f}", ""
    power = f"·10{str(int(exponent)).translate(_RAISED)}" if exponent else ""
    return _minus(_without_sign_of_zero(mantissa)) + power


def percent(share: float, digits: int = 2) -> str:
    """A share in per cent.

    Args:
        share: The share [1].
        digits: Significant digits.

    Returns:
        "1.2 %"; "–" for a share that isn't known.
    """
    return f"{plain(100 * share, digits)} %" if math.isfinite(share) else "–"


def plain(value: float, digits: int = 2) -> str:
    """A number to some significant digits, written without an exponent.

    Args:
        value: The number.
        digits: Significant digits; more before the decimal point are kept.

    Returns:
        The number; 0 for one below the last of 12 decimals, which is rounding.
    """
    if not math.isfinite(value):
        return short(value)
    if abs(value) < 10.0**-_MOST_DECIMALS:
        return "0"
    places = digits - 1 - math.floor(math.log10(abs(value)))
    return _minus(f"{value:.{min(max(places, 0), _MOST_DECIMALS)}f}")


def readable_unit(unit: str) -> str:
    """A unit as it is printed in a table.

    Args:
        unit: Unit in the code's notation, "kg m^2".

    Returns:
        The same with raised digits, "kg m²".
    """
    return unit.replace("^2", "²")


def capitalised(text: str) -> str:
    """A text with a capital at its beginning, the rest as it is.

    Args:
        text: The text.

    Returns:
        The same, as a sentence begins.
    """
    return text[:1].upper() + text[1:]


def _minus(text: str) -> str:
    return text.replace("-", "−")


def _without_sign_of_zero(text: str) -> str:
    """A number's text, whose zero has no sign."""
    return text.lstrip("-") if not text.strip("-0.") else text


def split_at_point(text: str) -> tuple[str, str]:
    """A number's text before the decimal point and from it on, to align a column.

    Args:
        text: The number's text.

    Returns:
        Both parts; the second is empty for a number without decimals.
    """
    whole, point, part = text.partition(".")
    return whole, point + part
