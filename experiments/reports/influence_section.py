"""Which run moves which quantity, and the bootstrap over runs, as tables and sentences."""

import math

import numpy as np
from jaxtyping import Bool

from experiments.page.number_text import plain, rounded
from experiments.page.table import Table
from experiments.reports.verdict import estimated
from identification.judge.influence import FEWEST, Influence, Interval
from identification.judge.uncertainty import ParameterEstimate
from identification.result.estimate import Estimate

DISSENTS = 3.0
"""Times what noise makes of it from which a run's influence is called more than noise [1]."""

WIDER = 1.5
"""Times the reported interval's width from which the bootstrap's is called wider [1]."""


def influence_tables(estimate: Estimate) -> tuple[Table, ...]:
    """What leaving out each run does, and the intervals from the bootstrap.

    Args:
        estimate: The estimate.

    Returns:
        Two tables, or none where nothing was estimated from more than one run.
    """
    found = estimate.influence
    if len(found.runs) < 2 or not found.names:
        return ()
    return (_left_out(found), _bootstrap(found, estimated(estimate)))


def influence_sentences(estimate: Estimate) -> tuple[str, ...]:
    """What the runs' influence says, in words.

    Args:
        estimate: The estimate.

    Returns:
        Sentences.
    """
    found = estimate.influence
    if len(found.runs) < 2 or not found.names:
        return ("A single run was fitted: there is none to leave out or to draw anew.",)
    noise = all(c.is_noise for run in estimate.comparisons for c in run.channels)
    return (
        *_alone(found),
        _strongest(found),
        *(() if noise or found.refitted else (FIRST_ORDER,)),
        *_wider(found, estimated(estimate)),
        *_too_few(found),
    )


FIRST_ORDER = (
    "The residuals are more than noise: leaving a run out also changes how much the other "
    "channels count, so that these steps may be half of what a fit without the run gives. "
    "`scdpr identify --leave-out` fits anew without each run."
)


def _left_out(found: Influence) -> Table:
    how = "a fit without it" if found.refitted else "one Gauss–Newton step"
    measured = _measured(found)
    rows = tuple(
        (run, *(_cell(*pair) for pair in zip(moved[measured], noise[measured], strict=True)))
        for run, moved, noise in zip(found.runs, found.moved, found.by_noise, strict=True)
    )
    return Table(
        f"Each run left out, by {how}: by how many of its standard errors each quantity moves "
        "(and by how many noise alone would)",
        ("without", *(_shown(found.names[k]) for k in np.flatnonzero(measured))),
        rows,
    )


def _measured(found: Influence) -> Bool[np.ndarray, " quantities"]:
    """Which quantities have a standard error to measure a move by."""
    return ~np.all(np.isnan(found.moved), axis=0)


def _cell(moved: float, noise: float) -> str:
    if math.isnan(moved):
        return "not told"
    sign = "−" if moved < 0 else "+"
    return f"{sign}{plain(abs(moved), 2)} ({plain(noise, 2)})"


def _bootstrap(found: Influence, parameters: tuple[ParameterEstimate, ...]) -> Table:
    rows = tuple(
        (_shown((p.name, p.setting)), *_ends(p, p.interval95), *_ends(p, own), plain(runs, 2))
        for p, own, runs in zip(
            parameters, found.interval95, found.telling.tolist(), strict=True
        )
    )
    return Table(
        f"95 % intervals: reported, and from {found.resamples} resamples of the runs (seed "
        f"{found.seed})",
        ("quantity", "from", "to", "runs drawn anew: from", "to", "runs that tell it"),
        rows,
    )


def _ends(parameter: ParameterEstimate, interval: Interval | None) -> tuple[str, str]:
    if interval is None:
        return ("too few runs", "")
    half = (parameter.interval95[1] - parameter.interval95[0]) / 2
    low, high = (rounded(end, half) if math.isfinite(end) else "none" for end in interval)
    return low, high


def _alone(found: Influence) -> tuple[str, ...]:
    """Which quantities a single run tells."""
    return tuple(
        f"Without {run} nothing tells the {_shown(name)}."
        for run, moved, values in zip(found.runs, found.moved, found.without, strict=True)
        for name, untold in zip(found.names, np.isnan(values), strict=True)
        if untold
    )


def _strongest(found: Influence) -> str:
    size = np.nan_to_num(np.abs(found.moved))
    more = size > DISSENTS * np.nan_to_num(found.by_noise, nan=np.inf)
    dissent = np.where(more & (size > 1), size, 0.0)
    looked_at = dissent if dissent.any() else size
    row, column = np.unravel_index(np.argmax(looked_at), size.shape)
    moved, noise = float(found.moved[row, column]), float(found.by_noise[row, column])
    told = (
        f"Without {found.runs[row]} the {_shown(found.names[column])} would be "
        f"{plain(abs(moved), 2)} standard errors {'larger' if moved > 0 else 'smaller'}, "
        f"where noise alone makes {plain(noise, 2)}"
    )
    if dissent.any():
        return (
            f"{told}: that run says something else than the others do. Look at its residuals, "
            "or fit without it."
        )
    return f"No run moves a quantity by more than noise explains. The most: {told}."


def _wider(found: Influence, parameters: tuple[ParameterEstimate, ...]) -> tuple[str, ...]:
    """Where the runs scatter by more than the reported intervals say."""
    told = []
    for p, own in zip(parameters, found.interval95, strict=True):
        reported = p.interval95[1] - p.interval95[0]
        if own is not None and own[1] - own[0] > WIDER * reported:
            times = plain((own[1] - own[0]) / reported, 2)
            told.append(f"{_shown((p.name, p.setting))} {times} times")
    if not told:
        return ()
    return (
        "Drawn anew the runs scatter by more than the reported intervals say: "
        f"{', '.join(told)} as wide. Other runs of the same kinds may give values as far "
        "apart.",
    )


def _too_few(found: Influence) -> tuple[str, ...]:
    few = [
        _shown(name)
        for name, own, measured in zip(
            found.names, found.interval95, _measured(found), strict=True
        )
        if own is None and measured
    ]
    if not few:
        return ()
    return (
        f"Too few runs for a bootstrap of {', '.join(few)}: it takes {FEWEST:g} that tell a "
        "quantity about equally well. Log more runs of the kinds that tell it.",
    )


def _shown(name: tuple[str, str | None]) -> str:
    return name[0].replace("_", " ") + (f" {name[1]}" if name[1] else "")
