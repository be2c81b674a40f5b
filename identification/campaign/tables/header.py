"""The header of a stream: which column stands where, in which unit."""

import dataclasses
import difflib
import re
from collections.abc import Iterator, Mapping, Sequence

from identification.campaign.faults import Fault
from identification.campaign.tables.columns import Column, Scale

_HEADER = re.compile(r"(?P<name>[^\[\]]+?) ?\[(?P<unit>[^\[\]]+)\]")


@dataclasses.dataclass(frozen=True)
class Header:
    """A stream's header, understood as far as it can be."""

    cells: tuple[str, ...]
    """The header's cells, trimmed."""
    columns: dict[int, Column]
    """Every known column, by its place."""
    units: dict[int, str]
    """The unit of each of these, as it is written."""
    extra: tuple[int, ...]
    """Places of the columns that the format doesn't know."""

    def scale(self, place: int) -> Scale:
        """Scale of a known column.

        Args:
            place: Its place.

        Returns:
            What its numbers become SI units by.
        """
        return self.columns[place].units[self.units[place]]


def read_header(
    cells: Sequence[str], expected: Sequence[Column], *, bare_extra: bool = False
) -> tuple[Header, tuple[Fault, ...]]:
    """What stands in which column.

    Args:
        cells: The header's cells as they are written.
        expected: The columns that the stream may have.
        bare_extra: Whether a column that the format doesn't know may be without a unit.

    Returns:
        The header, and what is wrong with it.
    """
    cells = tuple(cell.strip() for cell in cells)
    misfit = _no_header(cells, expected)
    if misfit is None:
        header, faults = _understood(cells, expected, bare_extra=bare_extra)
    else:
        header, faults = Header(cells, {}, {}, ()), [misfit]
    return header, tuple(dataclasses.replace(fault, row=1) for fault in faults)


def _understood(
    cells: tuple[str, ...], expected: Sequence[Column], *, bare_extra: bool
) -> tuple[Header, list[Fault]]:
    """The header of cells with names and units, and the faults of single cells."""
    known, seen = {column.name: column for column in expected}, set()
    columns, units, extra, faults = {}, {}, [], []
    for place, cell in enumerate(cells):
        match = _HEADER.fullmatch(cell)
        name, unit = (match["name"], match["unit"]) if match else (_bare_name(cell), "")
        if match is None and (name in known or not bare_extra):
            faults.append(_without_unit(cell, place, known))
        elif name in seen:
            faults.append(_twice(cell, name))
        elif name not in known:
            extra.append(place)
        elif unit not in known[name].units:
            faults.append(_unknown_unit(cell, unit, known[name]))
        else:
            columns[place], units[place] = known[name], unit
        seen.add(name)
    faults.extend(_missing(expected, seen, cells))
    return Header(cells, columns, units, tuple(extra)), faults


def _no_header(cells: tuple[str, ...], expected: Sequence[Column]) -> Fault | None:
    """The fault of a first row that is no header of this format at all."""
    example = ",".join(column.header for column in expected if not column.partner)
    for mark, word in ((";", "semicolons"), ("\t", "tabulators")):
        if len(cells) == 1 and mark in cells[0]:
            return Fault(
                what=f"columns separated by {word}",
                got=repr(cells[0]),
                expected="commas between columns and points in decimals",
                remedy="Export the log again with these separators: "
                + ",".join(part.strip() for part in cells[0].split(mark))
                + "; or bring it in with `scdpr import`.",
            )
    if all(_is_number(cell) for cell in cells):
        return Fault(
            what="no header row",
            got=repr(",".join(cells)),
            expected="each column's name and unit",
            remedy=f"Put a header above the first sample: {example}",
        )
    return None


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _bare_name(cell: str) -> str:
    """What is likely the name in a header that isn't written as it should be."""
    return re.split(r"[\[(]", cell)[0].strip()


def _without_unit(cell: str, place: int, columns: Mapping[str, Column]) -> Fault:
    name = _bare_name(cell)
    if not cell:
        remedy = f"Name column {place + 1}, or delete it; a comma too many makes one."
    elif name in columns:
        remedy = f'Write "{columns[name].header}", with the unit that was logged.'
    else:
        remedy = f'Write "{name} [unit]", with [1] for a number without unit.'
    accepted = columns[name].accepted if name in columns else "[...]"
    return Fault(
        what="a column without a unit",
        column=cell,
        got=repr(cell),
        expected=f"a name, a space and a unit in square brackets: {accepted}",
        remedy=remedy,
    )


def _twice(cell: str, name: str) -> Fault:
    return Fault(
        what="a column that is there twice",
        column=cell,
        got=f"a second {name!r}",
        expected="every name once",
        remedy="Rename or delete one of them.",
    )


def _unknown_unit(cell: str, unit: str, column: Column) -> Fault:
    remedy = f'Convert the column, or correct its header: "{column.header}".'
    if unit == "count":
        remedy = "Set `counts_per_rev` in campaign.toml: the counts of one turn of the pulley."
    return Fault(
        what="a unit that this column can't have",
        column=cell,
        got=f"[{unit}]",
        expected=f"one of {column.accepted}",
        remedy=remedy,
    )


def _missing(
    expected: Sequence[Column], seen: set[str], cells: tuple[str, ...]
) -> Iterator[Fault]:
    unclaimed = sorted(seen - {column.name for column in expected})
    for column in expected:
        needed = not column.partner or column.partner in seen
        if column.name in seen or not needed:
            continue
        near = difflib.get_close_matches(column.name, unclaimed, n=1)
        if near:
            remedy = f'Is it "{near[0]}"? Then rename that to "{column.header}".'
        elif column.partner:
            remedy = f'Log "{column.header}" too, or delete "{column.partner}".'
        else:
            remedy = f'Log it, with the header "{column.header}".'
        yield Fault(
            what=f"column {column.name!r} is missing",
            got=", ".join(cells),
            expected=f"{column.name!r} with one of {column.accepted}",
            remedy=remedy,
        )
