"""Which run moves which quantity, and the bootstrap over runs, as tables."""

import math

import numpy as np

from experiments.page.number_text import plain, rounded
from experiments.page.table import Table
from experiments.reports.calibration.heat_tables import quantity_symbols
from experiments.studies.findings.influence import has_error
from experiments.studies.findings.parameters import estimated
from identification.judge.influence import Influence, Interval
from identification.judge.uncertainty import ParameterEstimate
from identification.result.estimate import Estimate

_TENTH = 0.1


def influence_tables(estimate: Estimate) -> tuple[Table, ...]:
    """What leaving out each run does, and the intervals from the bootstrap.

    Args:
        estimate: The estimate.

    Returns:
        Two tables, or none where nothing was estimated from more than one run.
    """
    influence = estimate.influence
    if len(influence.runs) < 2 or not influence.names:
        return ()
    return (_left_out(influence), _bootstrap(influence, estimated(estimate)))


def _left_out(influence: Influence) -> Table:
    how = "a fit without it" if influence.refitted else "one Gauss–Newton step"
    measured = has_error(influence)
    rows = tuple(
        (run, *(_cell(*pair) for pair in zip(moved[measured], noise[measured], strict=True)))
        for run, moved, noise in zip(
            influence.runs, influence.moved, influence.by_noise, strict=True
        )
    )
    return Table(
        f"Each run left out, by {how}: by how many of its standard errors each quantity moves "
        "(and by how many noise alone would)",
        (
            "without",
            *quantity_symbols(tuple(influence.names[k] for k in np.flatnonzero(measured))),
        ),
        rows,
    )


def _cell(moved: float, noise: float) -> str:
    if math.isnan(moved):
        return "not told"
    size = _short(abs(moved))
    sign = "" if not size.strip("0.") else "−" if moved < 0 else "+"
    return f"{sign}{size} ({_short(noise)})"


def _short(errors: float) -> str:
    """Standard errors to two digits, and to no more than a hundredth of one."""
    return f"{errors:.2f}" if errors < _TENTH else plain(errors, 2)


def _bootstrap(influence: Influence, parameters: tuple[ParameterEstimate, ...]) -> Table:
    symbols = quantity_symbols(tuple((p.name, p.setting) for p in parameters))
    rows = tuple(
        (
            symbol,
            *_ends(p, p.interval95),
            *_ends(p, own),
            plain(runs, 2),
        )
        for symbol, p, own, runs in zip(
            symbols, parameters, influence.interval95, influence.telling.tolist(), strict=True
        )
    )
    return Table(
        f"95 % intervals: reported, and from {influence.resamples} resamples of the runs (seed "
        f"{influence.seed})",
        ("quantity", "from", "to", "runs drawn anew: from", "to", "runs that tell it"),
        rows,
    )


def _ends(parameter: ParameterEstimate, interval: Interval | None) -> tuple[str, str]:
    if interval is None:
        return ("too few runs", "")
    half = parameter.half_width
    low, high = (rounded(end, half) if math.isfinite(end) else "none" for end in interval)
    return low, high
