"""The unit and the symbol of a field, as its metadata."""


def si(unit: str, symbol: str = "") -> dict[str, str]:
    """Metadata of a field: its SI unit and its symbol in the paper.

    Args:
        unit: SI unit as it is printed, "1" for none.
        symbol: Symbol in TeX, without dollars.

    Returns:
        What `equinox.field(metadata=...)` takes.
    """
    return {"unit": unit, "symbol": symbol}
