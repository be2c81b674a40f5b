"""Dates and times as seconds: from texts as logs write them, and from large numbers."""

import math
import re
import warnings

import numpy as np
from jaxtyping import Float64, Shaped

LATE = 1e8
"""Time from which on a clock counts from a date, not from the log's begin [s]: three years."""
_TRIED = 8
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
    import pandas

    if len(texts) > 2 * _TRIED and from_texts(texts[:_TRIED]) is None:
        return None  # words, as the first of them show
    cells = pandas.Series(np.asarray(texts, dtype=str)).str.strip()
    cells = cells.str.replace(",", ".", regex=False)
    if all(_CLOCK.fullmatch(cell) for cell in cells):
        parts = pandas.to_timedelta(cells.where(cells.str.count(":") == 2, cells + ":00"))
        seconds = parts.to_numpy().astype("timedelta64[ns]").astype(np.int64) / 1e9
        return None, seconds + _DAY * np.cumsum(np.r_[0, np.diff(seconds) < -_DAY / 2])
    day_first = not cells.str.contains("/", regex=False).all()
    for chosen in ({"format": "ISO8601"}, {"format": "mixed", "dayfirst": day_first}):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                stamps = pandas.to_datetime(cells, utc=True, **chosen)
        except (ValueError, OverflowError):
            continue
        whole = stamps.dt.tz_convert(None).to_numpy().astype("datetime64[ns]").astype(np.int64)
        epoch = int(whole[0] // 10**9)
        return epoch, (whole - epoch * 10**9) / 1e9
    return None


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
