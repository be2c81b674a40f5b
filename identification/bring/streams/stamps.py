"""Dates and times as seconds: from texts as logs write them, and from large numbers."""

import itertools
import math
import re
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64, Int64, Shaped

if TYPE_CHECKING:
    import pandas

LATE = 1e8
"""Time from which on a clock counts from a date, not from the log's begin [s]: three years."""
_TRIED = 8
_BLOCK = 2**16
"""Texts that are parsed at a time: a date takes a hundred bytes on its way."""
_DAY = 86400.0
_CLOCK = re.compile(r"\d{1,2}:\d{2}(:\d{2}([.,]\d+)?)?")


def from_texts(
    texts: Shaped[np.ndarray, " samples"],
) -> tuple[int | None, Float64[np.ndarray, " samples"]] | None:
    """Seconds of dates and times.

    Args:
        texts: Such as "2026-11-30T10:00:00.125Z", "30.11.2026 10:00:00,125", "10:00:00.125".

    Returns:
        Whole seconds since 1970 that the times count from, None of times without a date;
        and the times [s]. None where a text is none.
    """
    if len(texts) > 2 * _TRIED and from_texts(texts[:_TRIED]) is None:
        return None  # words, as the first of them show
    blocks = [texts[first : first + _BLOCK] for first in range(0, len(texts), _BLOCK)]
    if all(map(_CLOCK.fullmatch, itertools.chain.from_iterable(map(_cells, blocks)))):
        seconds = np.concatenate([_of_clock(block) for block in blocks])
        return None, seconds + _DAY * np.cumsum(np.r_[0, np.diff(seconds) < -_DAY / 2])
    day_first = not all("/" in text for text in texts)
    for chosen in ({"format": "ISO8601"}, {"format": "mixed", "dayfirst": day_first}):
        try:
            whole = np.concatenate([_of_dates(block, chosen) for block in blocks])
        except (ValueError, OverflowError):
            continue
        epoch = int(whole[0] // 10**9)
        return epoch, (whole - epoch * 10**9) / 1e9
    return None


def _cells(texts: Shaped[np.ndarray, " samples"]) -> "pandas.Series":
    import pandas

    cells = pandas.Series(texts.tolist(), dtype=object).str.strip()
    return cells.str.replace(",", ".", regex=False)


def _of_clock(texts: Shaped[np.ndarray, " samples"]) -> Float64[np.ndarray, " samples"]:
    """Seconds since midnight."""
    import pandas

    cells = _cells(texts)
    parts = pandas.to_timedelta(cells.where(cells.str.count(":") == 2, cells + ":00"))
    return parts.to_numpy().astype("timedelta64[ns]").astype(np.int64) / 1e9


def _of_dates(
    texts: Shaped[np.ndarray, " samples"], chosen: Mapping[str, Any]
) -> Int64[np.ndarray, " samples"]:
    """Nanoseconds since 1970.

    Raises:
        ValueError: If a text is no date written so.
        OverflowError: If it lies too far away.
    """
    import pandas

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        stamps = pandas.to_datetime(_cells(texts), utc=True, **chosen)
    return stamps.dt.tz_convert(None).to_numpy().astype("datetime64[ns]").astype(np.int64)


def since_1970(stamps: Float64[np.ndarray, " samples"]) -> str:
    """The unit of stamps that count from 1970, which their size tells: this century has one.

    Args:
        stamps: The stamps.

    Returns:
        "s", "ms", "us" or "ns".
    """
    size = float(np.nanmax(np.abs(stamps), initial=0.0))
    return next((u for u, top in (("s", 1e11), ("ms", 1e14), ("us", 1e17)) if size < top), "ns")


def from_numbers(
    seconds: Float64[np.ndarray, " samples"],
) -> tuple[int | None, Float64[np.ndarray, " samples"]]:
    """Times that count from a date, counted from nearby.

    Args:
        seconds: Times [s].

    Returns:
        Whole seconds that the times count from, None where these are small already; and the
        times from there [s].
    """
    first = seconds[0]
    if not math.isfinite(first) or abs(first) < LATE:
        return None, seconds
    epoch = math.floor(first)
    return epoch, seconds - epoch
