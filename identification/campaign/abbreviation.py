"""Names that a user shortens: a run's number, a quantity's symbol."""

from collections.abc import Iterable, Mapping

SYMBOLS: Mapping[str, str] = {
    "mu": "friction_coefficient",
    "J": "drive_inertia",
    "b": "drive_damping",
    "T_eff": "effective_pretension",
    "tau_f": "drive_friction",
}
"""Symbols of the paper that stand for the names of quantities."""


def full_names(
    given: Iterable[str], known: Iterable[str], *, argument: str, what: str
) -> tuple[str, ...]:
    """The names that abbreviations stand for.

    Args:
        given: Names, their beginnings, or for quantities their symbols.
        known: Every name that there is.
        argument: The argument that names them, "--free".
        what: What is named, "quantity".

    Returns:
        The names in the order in which they are given.

    Raises:
        ValueError: If one stands for none, or for several.
    """
    names = tuple(known)
    return tuple(_full(each, names, argument=argument, what=what) for each in given)


def _full(given: str, known: tuple[str, ...], *, argument: str, what: str) -> str:
    if given in known:
        return given
    symbol = SYMBOLS.get(given)
    if symbol in known:
        return symbol
    # A beginning is meant before what stands somewhere inside.
    for near in (
        [name for name in known if name.startswith(given)],
        [name for name in known if given in name],
    ):
        if len(near) == 1:
            return near[0]
        if near:
            break
    expected = near or known
    kind = "stands for several" if near else "no such"
    raise ValueError(
        f"`{argument}`: {kind} {what}, got {given!r}, expected one of: {', '.join(expected)}. "
        "Give its name, or as much of it as no other has."
    )
