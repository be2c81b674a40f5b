"""The cells of a measured spectrum's CSV file, with one clear error."""

import csv
import dataclasses
import pathlib
import re

from scdpr_jax.numerics.files.given import CELL, SHORT_TABLE, read_given_text

EXPECTED = "a header such as 'freq,psd_x,psd_y,psd_z,psd_xyz' and a row of numbers per bin"
"""What such a file holds, for messages."""
_SHOWN = 60  # characters of a line in a message
_DECIMAL_COMMA = re.compile(r"\d,\d")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


@dataclasses.dataclass(frozen=True)
class SpectrumTable:
    """A header and the rows below it, as they are written."""

    path: pathlib.Path
    """The file."""
    line: int
    """The header's line, from 1."""
    header: tuple[str, ...]
    """The header's cells, trimmed."""
    rows: tuple[tuple[int, tuple[str, ...]], ...]
    """The rows with their lines."""


def read_table(path: pathlib.Path) -> SpectrumTable:
    """Read a file's header and rows.

    Lines that begin with '#' are comments; the last one above the numbers is the header if
    there is no other. Empty cells behind the last column are no cells.

    Args:
        path: The file.

    Returns:
        Header and rows.

    Raises:
        FileNotFoundError: If there is no such file.
        ValueError: If it isn't text in columns between commas; says what it is instead.
    """
    lines = read_given_text(path, most=SHORT_TABLE).splitlines()
    numbered = [(n, line) for n, line in enumerate(lines, start=1) if line.strip(" \t,;")]
    if not numbered:
        raise ValueError(
            f"{path}: got an empty file, expected {EXPECTED}. Export the spectrum again."
        )
    comments = [each for each in numbered if each[1].lstrip().startswith("#")]
    rows = [each for each in numbered if not each[1].lstrip().startswith("#")]
    if comments and (not rows or _NUMBER.match(rows[0][1].strip())):
        above = [each for each in comments if not rows or each[0] < rows[0][0]]
        rows = [*above[-1:], *rows]
    _check_separator(path, rows)
    cells = [(n, _cells(path, n, line)) for n, line in rows]
    line, header = cells[0]
    _check_decimal_point(path, cells)
    return SpectrumTable(
        path, line, header, tuple((n, _without_empty(row, len(header))) for n, row in cells[1:])
    )


def _cells(path: pathlib.Path, number: int, line: str) -> tuple[str, ...]:
    try:
        (row,) = csv.reader([line])
    except csv.Error as error:
        raise ValueError(
            f"{path}, row {number}: {error}, got {line[:_SHOWN]!r}, expected {EXPECTED}. "
            "Export the spectrum as CSV (UTF-8)."
        ) from None
    if any(len(cell) > CELL for cell in row):
        raise ValueError(
            f"{path}, row {number}: a cell longer than {CELL} characters, got "
            f"{line[:_SHOWN]!r}, expected {EXPECTED}. Export the spectrum as CSV (UTF-8)."
        )
    return _without_empty(tuple(cell.strip() for cell in row), 0)


def _without_empty(row: tuple[str, ...], least: int) -> tuple[str, ...]:
    """A row without the empty cells at its end; those of named columns stay."""
    while len(row) > least and not row[-1]:
        row = row[:-1]
    return row


def _check_separator(path: pathlib.Path, rows: list[tuple[int, str]]) -> None:
    line, header = rows[0]
    for separator, name in ((";", "';'"), ("\t", "a tab")):
        if header.count(separator) <= header.count(","):
            continue
        example = rows[1][1] if len(rows) > 1 else ""
        commas = any(_DECIMAL_COMMA.search(row) for _, row in rows[1:])
        point = " and the decimal point ','" if commas else ""
        written = {";": ";", "\t": "\\t"}[separator]
        pairs = f"',{written}' '.,'" if commas else f"'{written}' ','"
        raise ValueError(
            f"{path}, row {line}: the separator is {name}{point}, got {header[:_SHOWN]!r} and "
            f"{example[:_SHOWN]!r}, expected the separator ',' and the decimal point '.'. "
            "Export it as CSV with these (a spreadsheet does in English), or convert it: "
            f"`tr {pairs} < {path.name} > converted.csv`."
        )


def _check_decimal_point(path: pathlib.Path, cells: list[tuple[int, tuple[str, ...]]]) -> None:
    """Whether each number was cut in two: `1,5,1503,32` below `freq,psd_x`."""
    (_, header), *rows = cells
    for number, row in rows[:1]:
        doubled = len(row) == 2 * len(header) and all(cell.isdecimal() for cell in row[1::2])
        quoted = any(_DECIMAL_COMMA.search(cell) for cell in row)
        if doubled or quoted:
            raise ValueError(
                f"{path}, row {number}: the decimal point is ',', got "
                f"{','.join(row)[:_SHOWN]!r} below {','.join(header)[:_SHOWN]!r}, expected "
                "the decimal point '.'. Export it as CSV with it (a spreadsheet does in "
                "English)."
            )
