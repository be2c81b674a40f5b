"""A channel's numbers as a column: not seen, wraps, scale, sign, unit, offset, in order."""

import dataclasses

import numpy as np
from jaxtyping import Float64

from identification.bring.files.channel import Channel
from identification.bring.mapping.document import ColumnTable
from identification.bring.streams.units import unit_scale
from identification.campaign.faults import Fault
from identification.campaign.quantities import QuantityError, parse_quantity
from identification.campaign.tables.columns import Column


@dataclasses.dataclass(frozen=True, eq=False)
class Numbers:
    """A column's numbers."""

    values: Float64[np.ndarray, " samples"]
    """Its numbers [SI], NaN where nothing was seen."""
    notes: tuple[str, ...]
    """What was done to them."""


def numbers(
    channel: Channel, column: Column, said: ColumnTable
) -> tuple[Numbers | None, Fault | None]:
    """A channel's numbers as a column of the format.

    Args:
        channel: The channel.
        column: The column.
        said: What the mapping says of it.

    Returns:
        The numbers, None if there is a fault; and the fault, without its file.
    """
    unit = said.unit or channel.unit
    scale = unit_scale(column, unit) if unit else None
    fault = _unfit(channel) or _bad_unit(column, unit, known=scale is not None)
    if fault is None:
        fault = _odd_cell(channel, said)
    offset, misfit = _offset(column, said)
    fault = fault or misfit
    if fault is not None:
        return None, dataclasses.replace(fault, column=column.name)
    notes = [f"{column.name} is {channel.name!r} in {unit}"]
    if not said.unit:
        notes[0] += ", as the log says"
    raw, lost = _seen(channel, said)
    if lost:
        notes.append(f"{lost} values that mean not seen")
    if said.wraps is not None:
        raw, wraps = unwrapped(raw, said.wraps)
        notes.append(f"{wraps} wraps at {said.wraps:g} taken out")
    values = raw if said.scale == 1 else raw * said.scale
    values = scale(values if said.sign == 1 else -values)
    if said.scale != 1 or said.sign != 1:
        notes.append(f"times {said.sign * said.scale:g}")
    if offset:
        values = values + offset
        notes.append(f"plus {said.offset}")
    return Numbers(values + 0.0, (", ".join(notes),)), None


def _seen(channel: Channel, said: ColumnTable) -> tuple[np.ndarray, int]:
    """The numbers, NaN for each that means not seen, and how many these are."""
    raw = channel.values
    codes = [code for code in said.lost if not isinstance(code, str)]
    lost = np.isin(raw, codes) if codes else np.zeros(len(raw), dtype=bool)
    count = int(lost.sum()) + len(channel.odd)
    return (np.where(lost, np.nan, raw) if lost.any() else raw), count


def unwrapped(
    raw: Float64[np.ndarray, " samples"], period: float
) -> tuple[Float64[np.ndarray, " samples"], int]:
    """A counter's numbers without its overflows.

    Args:
        raw: The numbers.
        period: By how much it jumps.

    Returns:
        The numbers, and how often it did.
    """
    turns = np.zeros(len(raw))
    seen = np.isfinite(raw)
    turns[seen] = np.r_[0.0, np.cumsum(-np.rint(np.diff(raw[seen]) / period))]
    return raw + period * turns, int(np.abs(np.diff(turns[seen])).sum())


def _unfit(channel: Channel) -> Fault | None:
    """Why a channel is no column of numbers."""
    if channel.missing:
        got, _, remedy = channel.missing.partition("|")
        return Fault(
            what="what only MATLAB can read",
            got=f"{channel.name!r}, {got}",
            expected="an array or a structure",
            remedy=remedy,
        )
    if not channel.is_number:
        return Fault(
            what="not a channel of numbers",
            got=f"{channel.name!r}, texts such as {str(channel.values.ravel()[:1])[:40]}",
            expected="numbers",
            remedy="Name another channel, or state `decimal` and `separator`.",
        )
    if channel.values.ndim != 1:
        shape = " by ".join(map(str, channel.values.shape))
        return Fault(
            what="not one column of numbers",
            got=f"{channel.name!r}, an array of {shape}",
            expected="one of its columns",
            remedy=f'Choose one: channel = "{channel.name}[:, 0]".',
        )
    return None


def _bad_unit(column: Column, unit: str, *, known: bool) -> Fault | None:
    if known:
        return None
    no_counts = unit.lower().startswith(("count", "inc", "tick")) and "rad" in column.units
    remedy = f'Write unit = "{next(iter(column.units))}", with the unit that was logged.'
    if no_counts:
        remedy = (
            "Counts need the counts of a turn: counts_per_rev in the campaign's campaign.toml, "
            "or in the mapping's [campaign]."
        )
    return Fault(
        what="a channel without a unit" if not unit else "a unit that this column can't have",
        got=repr(unit) if unit else "no unit, neither in the mapping nor in the log",
        expected=f"one such as {column.accepted}",
        remedy=remedy,
    )


def _odd_cell(channel: Channel, said: ColumnTable) -> Fault | None:
    """The first cell that is no number and doesn't mean not seen."""
    codes = {code for code in said.lost if isinstance(code, str)}
    rest = {sample: text for sample, text in channel.odd.items() if text not in codes}
    if not rest:
        return None
    sample, text = next(iter(rest.items()))
    more = f", the first of {len(rest)}" if len(rest) > 1 else ""
    return Fault(
        what="not a number",
        row=channel.row(sample),
        got=f"{text[:40]!r} in {channel.name!r}{more}",
        expected="a number",
        remedy=f'If it means not seen, write lost = ["{text[:20]}"]; else correct the cell.',
    )


def _offset(column: Column, said: ColumnTable) -> tuple[float, Fault | None]:
    if said.offset is None:
        return 0.0, None
    try:
        return parse_quantity(said.offset, unit=next(iter(column.units)), name="offset"), None
    except QuantityError as error:
        return 0.0, Fault(
            what=f"`offset` is {error.problem}",
            got=error.got,
            expected=error.expected,
            remedy=error.remedy,
        )
