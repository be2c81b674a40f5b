"""Notes on a run that can be read: what a careful colleague would see in the log."""

import dataclasses
from collections.abc import Callable, Iterator

import numpy as np
from jaxtyping import Bool

from identification.campaign.types import Campaign, Run
from scdpr_jax.numerics.files.harmless import printable, shortened
from scdpr_jax.robot.stated.numbers import PROVENANCE

_TYPICAL = {source.name: source.consistent for source in PROVENANCE}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Note:
    """Something that is worth knowing, and no fault."""

    file: str = ""
    """The file, relative to the campaign's folder; of several, the first and how many."""
    what: str
    """What was seen, with its figures."""
    cause: str
    """What it usually comes from, or what it does to the result."""
    remedy: str
    """What can be done about it."""

    @property
    def text(self) -> str:
        """What, cause and remedy, wherever it was seen."""
        return printable(f"{shortened(self.what)}. {self.cause} {self.remedy}")

    def __str__(self) -> str:
        return f"{printable(self.file)}: {self.text}"


Observation = Callable[[Run, Campaign], Iterator[Note]]
"""What looks at a run and notes what it sees, without the file."""


def early_motion(motion: str, start: float) -> Note:
    """The note of a motion before its cause, whichever sensor shows it.

    Args:
        motion: What moves, and how far.
        start: Time of the first command or knock [s].

    Returns:
        The note.
    """
    return Note(
        what=f"moves before anything is commanded: {motion} before t = {start:.4g} s",
        cause="An amplifier's offset, a start that wasn't at rest, or clocks that disagree.",
        remedy="Trim the amplifier, wait for standstill, check clock_offset and [knock].",
    )


def share(flags: Bool[np.ndarray, " _"]) -> str:
    """A share of samples, as it is printed.

    Args:
        flags: Whether each sample belongs to it.

    Returns:
        The share in percent.
    """
    return f"{100 * float(np.mean(flags)):.2g} %"


def rig_value(name: str, campaign: Campaign) -> float:
    """A quantity of the robot: the campaign's, or else that of the paper's rig.

    Args:
        name: A name of `scdpr_jax.robot.quantities.QUANTITIES`.
        campaign: The campaign.

    Returns:
        Its value [SI].
    """
    return campaign.robot.get(name, _TYPICAL[name])
