"""What a verb says, and how it ends, where it rests on a fit that has failed."""

import pathlib

from experiments.verbs.console import say
from experiments.verbs.exit_status import DONE, FELL_SHORT


def ending(source: pathlib.Path, *, fits: bool) -> int:
    """The exit status of what was made from a fit; a failed one is told first.

    Args:
        source: The file that the fit, or what was made from it, was read from.
        fits: Whether the fit hasn't failed.

    Returns:
        `DONE`, or `FELL_SHORT` where it has.
    """
    if fits:
        return DONE
    say(
        f"THE MODEL DOES NOT FIT the runs that {source} comes from. What follows is for a "
        "robot that isn't the one on the rig: find the cause first, see `scdpr identify`.",
        style="bold red",
    )
    return FELL_SHORT
