"""The table of parameters: what was estimated, how sure, and beside the truth."""

import dataclasses
import math
from collections.abc import Sequence

from experiments.page.coordinates import plain_symbol
from experiments.page.number_text import percent, readable_unit, rounded
from experiments.page.table import Table
from experiments.studies.findings.parameters import inside
from identification.judge.uncertainty import ParameterEstimate
from scdpr_jax.robot.quantities import EVERY_QUANTITY


@dataclasses.dataclass(frozen=True)
class Row:
    """A parameter's line, its numbers as they are printed."""

    name: str
    """Name in the file formats."""
    symbol: tuple[str, str]
    """Symbol and its index."""
    meaning: str
    """What it is."""
    setting: str
    """Nominal pretension that it belongs to, empty if to all."""
    value: str
    """Value."""
    low: str
    """Lower end of the 95 % interval, empty for a fixed value."""
    high: str
    """Upper end."""
    relative: str
    """Half of the interval over the value; of one that may be zero only that it is more."""
    unit: str
    """SI unit, empty for none."""
    status: str
    """What the estimate is worth."""
    truth: str
    """True value, empty where it isn't known."""
    error: str
    """Estimate minus truth over truth."""
    covered: str
    """Whether the 99.7 % interval covers the truth: yes, no, or empty."""


def parameter_row(
    parameter: ParameterEstimate, *, truth: dict[str, float] | None = None
) -> Row:
    """A parameter's line.

    Args:
        parameter: The parameter.
        truth: True values by name [SI], where they are known.

    Returns:
        The line.
    """
    quantity = {quantity.name: quantity for quantity in EVERY_QUANTITY}.get(parameter.name)
    low, high = parameter.interval95
    half = parameter.half_width
    fixed = parameter.status == "fixed"
    # What no run shows has no interval, and none is invented.
    untold = fixed or not math.isfinite(half)
    true = None if fixed else (truth or {}).get(parameter.name)
    return Row(
        name=parameter.name,
        symbol=plain_symbol(quantity.symbol) if quantity else ("", ""),
        meaning=quantity.meaning if quantity else parameter.name.replace("_", " "),
        setting=parameter.setting or "",
        value=rounded(parameter.value, half),
        low="" if untold else rounded(low, half),
        high="" if untold else rounded(high, half),
        relative="" if untold else _relative(parameter),
        unit="" if parameter.unit == "1" else readable_unit(parameter.unit),
        status=parameter.status.replace("_", " "),
        truth="" if true is None else rounded(true, half),
        error="" if not true else signed_percent(parameter.value / true - 1),
        covered="" if true is None else ("yes" if inside(parameter, true) else "no"),
    )


def _relative(parameter: ParameterEstimate) -> str:
    if parameter.may_be_zero:
        return "> 100 %"
    return percent(parameter.half_width / abs(parameter.value))


def parameters_table(rows: Sequence[Row], *, with_truth: bool) -> Table:
    """The table of parameters for a terminal.

    Args:
        rows: The parameters' lines.
        with_truth: Whether to set the truth beside them.

    Returns:
        The table.
    """
    header = ("quantity", "setting", "value", "95 % from", "to", "unit", "±", "status")
    truth = ("truth", "error", "inside 99.7 %")
    lines = []
    for row in rows:
        line = (row.name, row.setting, row.value, row.low, row.high, row.unit, row.relative)
        known = (row.truth, row.error, row.covered) if with_truth else ()
        lines.append((*line, row.status, *known))
    return Table(
        "",
        (*header, *(truth if with_truth else ())),
        tuple(lines),
        words=(0, 1, 5, 7, 10),
        # Half of the interval tells it, and the error stands beside the truth.
        spare=((3, 4), (9,)) if with_truth else ((3, 4),),
    )


def signed_percent(share: float) -> str:
    """A share in per cent with its sign.

    Args:
        share: The share [1].

    Returns:
        "+0.0031 %".
    """
    text = percent(share)
    return text if text.startswith("−") else f"+{text}"
