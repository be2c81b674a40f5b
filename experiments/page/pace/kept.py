"""How computations went on this machine, for the next time."""

import json
import pathlib

from experiments.page.pace.clock import EVEN, Pace
from experiments.page.pace.usual import MODELS, THE_WHOLE, USUAL
from scdpr_jax.numerics.files import write_whole

_KEPT = 50
"""Paces that are kept, the last ones."""


def expected(name: str, kept: pathlib.Path | None, *, given: str = "") -> Pace:
    """How a computation will go: as with this input, as the last time, or as it usually goes.

    Args:
        name: Its name.
        kept: Where paces are kept; None where nowhere.
        given: What it is given, by a name that lasts.

    Returns:
        The pace.
    """
    every = _kept(kept)
    if name not in USUAL:
        return every.get(f"{name} {given}".rstrip(), every.get(name, EVEN))
    usual = USUAL[name]
    pace = usual.first if {name, *THE_WHOLE}.isdisjoint(every) else usual.again
    if name in every:
        pace = pace.scaled(every[name].total)
    own = every.get(f"{name} {given}") if given else None
    return (own or pace).with_detour(
        usual.first_detour if MODELS not in every else usual.detour
    )


def keep(name: str, pace: Pace, kept: pathlib.Path | None, *, given: str = "") -> None:
    """Keep how a computation went, for the next time.

    The first time on a machine compiles, and the second doesn't: the first is no measure for
    the second but for the machine's speed. Neither is another input, which may take ten times
    as long, where it is known how a computation usually goes.

    Args:
        name: Its name.
        pace: How it went.
        kept: Where paces are kept; None where nowhere.
        given: What it was given, by a name that lasts.
    """
    if kept is None:
        return
    every = _kept(kept)
    own, usual = f"{name} {given}".rstrip(), USUAL.get(name)
    if usual is not None and usual.detour is not None and usual.detour.taken(pace):
        every[MODELS] = pace
    if usual is not None and {name, *THE_WHOLE}.isdisjoint(every):
        every[name] = usual.again.scaled(usual.again.total * pace.total / usual.first.total)
    else:
        for known in {own} if usual is not None else {own, name}:
            every[known] = pace.after(every.pop(known)) if known in every else pace
    last = list(every.items())[-_KEPT:]
    document = {known: [each.total, each.points] for known, each in last}
    try:
        write_whole(kept, json.dumps(document))
    except OSError:
        return  # A bar that knows less the next time is no reason to fail.


def _kept(file: pathlib.Path | None) -> dict[str, Pace]:
    """What is kept; nothing where it can't be read, or isn't what was written."""
    if file is None or not file.exists():
        return {}
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
        return {
            name: Pace(float(total), tuple((float(a), float(b)) for a, b in points))
            for name, (total, points) in document.items()
            if total > 0
        }
    except (OSError, ValueError, TypeError, AttributeError):
        return {}
