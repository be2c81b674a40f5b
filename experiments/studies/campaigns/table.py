"""The table of many campaigns: a row for each campaign and quantity, or the reason for none."""

import csv
import io
import math
import pathlib
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from experiments.studies.campaigns.unit import Answer
from scdpr_jax.numerics.files import whole_file, write_whole
from scdpr_jax.numerics.files.harmless import cell, printable

MEANINGS = {
    "campaign": "name of the campaign's folder",
    "name": "the quantity; empty where there is none",
    "setting": "nominal pretension where the value belongs to one",
    "value": "value, in the unit of its row",
    "unit": "SI unit",
    "sigma": "standard error, in the unit of its row; nan: not known",
    "low": "lower end of the 95 % interval; nan: not bounded",
    "high": "upper end of the 95 % interval; nan: not bounded",
    "status": "identified, weak, unidentifiable, at_bound, fixed or model_does_not_fit",
    "reason": "why there is no value, or why it isn't to be used",
    "logs": "SHA-256 of the logs, its first digits",
    "version": "version of scdpr-jax",
}
"""The columns, and what they say."""

_NUMBERS = ("value", "sigma", "low", "high")


class Row(NamedTuple):
    """A quantity of a campaign, or the campaign's failure."""

    campaign: str
    name: str = ""
    setting: str = ""
    value: float = math.nan
    unit: str = ""
    sigma: float = math.nan
    low: float = math.nan
    high: float = math.nan
    status: str = ""
    reason: str = ""
    logs: str = ""
    version: str = ""


def rows(name: str, answer: Answer) -> Iterator[Row]:
    """The rows of a campaign.

    Args:
        name: Its name.
        answer: What became of it.

    Yields:
        A row for each quantity; one where there is none.
    """
    # A line end in a reason is a gap, and whatever else moves a cursor is written out.
    campaign, reason = printable(name), printable(" ".join(answer.reason.split()))
    if not answer.document:
        yield Row(campaign, reason=reason)
        return
    for own in answer.parameters:
        low, high = own["interval95"]
        numbers = (own["value"], own["sigma"], low, high)
        value, sigma, low, high = (math.nan if n is None else float(n) for n in numbers)
        yield Row(
            campaign,
            own["name"],
            own["setting"] or "",
            value,
            own["unit"],
            sigma,
            low,
            high,
            own["status"],
            reason,
            answer.provenance.source,
            answer.provenance.version,
        )


def write_csv(path: pathlib.Path, table: list[Row]) -> None:
    """Write the table as text, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        table: The rows; what isn't known is empty.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(MEANINGS)
    writer.writerows(map(_cells, table))
    write_whole(path, text.getvalue())


def write_netcdf(path: pathlib.Path, table: list[Row], *, scratch: pathlib.Path) -> None:
    """Write the table as netCDF, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        table: The rows.
        scratch: A folder on the same disk for the file while it isn't whole.
    """
    columns = {
        name: ("row", _column(name, table), {"long_name": meaning})
        for name, meaning in MEANINGS.items()
    }
    dataset = xr.Dataset(columns, attrs={"title": "scdpr identify of several campaigns"})
    with whole_file(path, named_in=scratch) as place:
        dataset.to_netcdf(place, engine="h5netcdf")


def _column(name: str, table: list[Row]) -> np.ndarray:
    values = [getattr(row, name) for row in table]
    return np.array(values, float if name in _NUMBERS else object)


def _cells(row: Row) -> list[Any]:
    """A row as a spreadsheet may open it."""
    return [cell(own) if isinstance(own, str) else _number(own) for own in row]


def _number(value: float) -> float | str:
    return "" if math.isnan(value) else value
