"""Faults of a campaign: data while it is read, one error when it is asked for."""

import dataclasses
import itertools
import re
from collections.abc import Iterable, Sequence

from scdpr_jax.numerics.files.given import FileError
from scdpr_jax.numerics.files.harmless import LINES, printable, shortened

_NAMED = 3
"""Files that are named, each by itself, of what is alike in them."""
_NUMBER = re.compile(r"\d[\d.,]*(e[+-]?\d+)?")
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

    @property
    def text(self) -> str:
        """What is wrong, what was found and expected, and the remedy, wherever it is."""
        parts = [shortened(self.what)]
        if self.got:
            parts.append(f"got {shortened(self.got)}")
        if self.expected:
            parts.append(f"expected {shortened(self.expected)}")
        # A remedy may be a line of MATLAB, which is to be pasted whole.
        return f"{', '.join(parts)}. {shortened(self.remedy, 600)}"

    def __str__(self) -> str:
        return printable(f"{self.where}: {self.text}")


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
        told = grouped(
            (file := shortened(fault.file), fault.where.removeprefix(file), fault.text)
            for fault in _one_of_each_first(faults)
        )
        left = len(told) + 1 - LINES
        if left > 0:
            told[_TOLD:] = [f"and {left + 1} more; `scdpr check --json FILE` tells every one."]
        lines = [f"{what} {path}: {number}.", *(f"  {line}" for line in told)]
        super().__init__("\n".join(map(printable, lines)))


def _one_of_each_first(faults: Sequence[Fault]) -> Sequence[Fault]:
    """Faults in order; where they are more than a message holds, one of each file first."""
    if len(faults) < LINES:
        return faults
    files: dict[str, int] = {}
    ranks = []
    for fault in faults:
        files[fault.file] = rank = files.get(fault.file, 0) + 1
        ranks.append(rank)
    return [faults[place] for place in sorted(range(len(faults)), key=ranks.__getitem__)]


def grouped(lines: Iterable[tuple[str, str, str]]) -> list[str]:
    """What is the same in many files, told once.

    Args:
        lines: A file, a place in it, and what is there; alike are those in the same place that
            differ in numbers only.

    Returns:
        A line for each, or for all that are alike in more than three files, in the order in
        which they come.
    """
    told = list(lines)
    kinds = [(place, _NUMBER.sub("0", text)) for _, place, text in told]
    files: dict[tuple[str, str], list[str]] = {}
    for kind, (file, _, _) in zip(kinds, told, strict=True):
        files.setdefault(kind, []).append(file)
    result: dict[tuple[str, str] | int, str] = {}
    for number, (kind, (file, place, text)) in enumerate(zip(kinds, told, strict=True)):
        more = len(set(files[kind])) - 1
        if more < _NAMED:
            result[number] = f"{file}{place}: {text}"
        else:
            among = f", and {more} more files, the last {files[kind][-1]}"
            result.setdefault(kind, f"{file}{place}{among}: {text}")
    return list(result.values())


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
