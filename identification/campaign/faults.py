"""Faults of a campaign: data while it is read, one error when it is asked for."""

import dataclasses
import itertools
from collections.abc import Iterable

_LISTED = 10
"""Faults of one file that are listed; a column that is wrong throughout has thousands."""


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
        parts = [self.file]
        if self.row is not None:
            parts.append(f"row {self.row}")
        if self.column:
            parts.append(f"column '{self.column}'")
        if self.key:
            parts.append(f"key '{self.key}'")
        return ", ".join(parts)

    def __str__(self) -> str:
        parts = [self.what]
        if self.got:
            parts.append(f"got {self.got}")
        if self.expected:
            parts.append(f"expected {self.expected}")
        return f"{self.where}: {', '.join(parts)}. {self.remedy}"


class CampaignError(ValueError):
    """A campaign that can't be used as it is, with all its faults."""

    def __init__(self, path: object, faults: tuple[Fault, ...], *, what: str = "campaign"):
        self.faults = faults
        """Every fault that was found."""
        number = "1 fault" if len(faults) == 1 else f"{len(faults)} faults"
        lines = [f"{what} {path}: {number}.", *(f"  {fault}" for fault in faults)]
        super().__init__("\n".join(map(printable, lines)))


def printable(text: str) -> str:
    """A line as a terminal may show it: what would move its cursor is written out.

    Args:
        text: The line, with names from wherever.

    Returns:
        The same without control characters and lone surrogates.
    """
    return "".join(
        mark if mark.isprintable() else mark.encode("unicode_escape").decode() for mark in text
    )


def listed(faults: Iterable[Fault], *, file: str) -> tuple[Fault, ...]:
    """The first faults of a file, and one that counts the rest.

    Args:
        faults: The file's faults in the order of its rows; read to the end.
        file: The file, relative to the campaign's folder.

    Returns:
        At most ten faults, and "and N more" where there are more, all of that file.
    """
    rest = iter(faults)
    first = [dataclasses.replace(fault, file=file) for fault in itertools.islice(rest, _LISTED)]
    more = sum(1 for _ in rest)
    if more:
        remedy = "Mend those above and check again: they often have one cause."
        first.append(Fault(what=f"and {more} more in this file", file=file, remedy=remedy))
    return tuple(first)
