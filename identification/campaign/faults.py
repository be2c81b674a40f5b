"""Faults of a campaign: data while it is read, one error when it is asked for."""

import dataclasses
import itertools
from collections.abc import Iterable, Sequence

from scdpr_jax.numerics.files.given import FileError
from scdpr_jax.numerics.files.harmless import LINES, printable, shortened

_LISTED = 10
"""Faults of one file that are listed; a column that is wrong throughout has thousands."""
_TOLD = LINES - 2
"""Faults of one message, between its first line and the one that counts the rest."""
_NAME = 80
"""Characters of a column's or a key's name in a message."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Fault:
    """One thing that is wrong with a campaign."""

    what: str
    """What is wrong."""
    file: str = ""
    """The file, relative to the campaign's folder; the folder itself if it is at fault. Whoever
    reads the file as a whole fills it in, see `listed`."""
    row: int | None = None
    """Line of the file as an editor counts it, from 1."""
    column: str = ""
    """Header of the column, of a CSV file."""
    key: str = ""
    """The key with its table, of a TOML file."""
    got: str = ""
    """What was found."""
    expected: str = ""
    """What was expected, with its unit."""
    remedy: str
    """How to mend it."""

    @property
    def where(self) -> str:
        """File, row, and column or key, as far as there are any."""
        parts = [shortened(self.file)]
        if self.row is not None:
            parts.append(f"row {self.row}")
        if self.column:
            parts.append(f"column '{shortened(self.column, _NAME)}'")
        if self.key:
            parts.append(f"key '{shortened(self.key, _NAME)}'")
        return ", ".join(parts)

    def __str__(self) -> str:
        parts = [shortened(self.what)]
        if self.got:
            parts.append(f"got {shortened(self.got)}")
        if self.expected:
            parts.append(f"expected {shortened(self.expected)}")
        # A remedy may be a line of MATLAB, which is to be pasted whole.
        return printable(f"{self.where}: {', '.join(parts)}. {shortened(self.remedy, 600)}")


def fault_of(error: FileError, *, file: str = "") -> Fault:
    """A file that isn't read, as a fault.

    Args:
        error: Why it isn't.
        file: The file as the message is to name it.

    Returns:
        The fault.
    """
    return Fault(
        what=error.what,
        file=file,
        got=error.got,
        expected=error.expected,
        remedy=error.remedy,
    )


class CampaignError(ValueError):
    """A campaign that can't be used as it is, with all its faults."""

    def __init__(self, path: object, faults: tuple[Fault, ...], *, what: str = "campaign"):
        self.faults = faults
        """Every fault that was found."""
        number = "1 fault" if len(faults) == 1 else f"{len(faults)} faults"
        lines = [f"{what} {path}: {number}.", *(f"  {fault}" for fault in _told(faults))]
        left = len(faults) + 1 - len(lines)
        if left:
            lines.append(f"  and {left} more; `scdpr check --json FILE` tells every one.")
        super().__init__("\n".join(map(printable, lines)))


def _told(faults: Sequence[Fault]) -> Sequence[Fault]:
    """As many faults as a message holds: of every file one, before more of the same."""
    if len(faults) < LINES:
        return faults
    files: dict[str, int] = {}
    ranks = []
    for fault in faults:
        files[fault.file] = rank = files.get(fault.file, 0) + 1
        ranks.append(rank)
    chosen = sorted(range(len(faults)), key=lambda place: (ranks[place], place))[:_TOLD]
    return [faults[place] for place in sorted(chosen)]


def listed(
    faults: Iterable[Fault], *, file: str, count: int | None = None
) -> tuple[Fault, ...]:
    """The first faults of a file, and one that counts the rest.

    Args:
        faults: The file's faults in the order of its rows.
        file: The file, relative to the campaign's folder.
        count: How many there are; counted to the end where it isn't known.

    Returns:
        At most ten faults, and "and N more" where there are more, all of that file.
    """
    rest = iter(faults)
    first = [dataclasses.replace(fault, file=file) for fault in itertools.islice(rest, _LISTED)]
    more = sum(1 for _ in rest) if count is None else count - len(first)
    if more > 0:
        remedy = "Mend those above and check again: they often have one cause."
        first.append(Fault(what=f"and {more} more in this file", file=file, remedy=remedy))
    return tuple(first)
