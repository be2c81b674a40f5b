"""Names that a user shortens: a run's number, a quantity's symbol."""

from collections.abc import Iterable, Mapping

from identification.campaign.types import Campaign
from scdpr_jax.robot.stated.names import EVERY_QUANTITY

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


def free_quantities(given: Iterable[str]) -> tuple[str, ...]:
    """Quantities to estimate.

    Args:
        given: What follows `--free`.

    Returns:
        Their names.

    Raises:
        ValueError: If one stands for no quantity, or for several.
    """
    known = [quantity.name for quantity in EVERY_QUANTITY]
    return full_names(given, known, argument="--free", what="quantity")


def run_names(campaign: Campaign, given: Iterable[str]) -> tuple[str, ...]:
    """Runs to predict instead of fitting them.

    Args:
        campaign: The campaign.
        given: What follows `--hold-out`.

    Returns:
        Their names.

    Raises:
        ValueError: If one stands for no run, or for several.
    """
    known = [run.name for run in campaign.runs]
    return full_names(given, known, argument="--hold-out", what="run")


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
    kind = "more than one" if near else "no such"
    raise ValueError(
        f"`{argument}`: {kind} {what}, got {given!r}, expected one of: {', '.join(expected)}. "
        "Give its name, or as much of it as no other has."
    )
