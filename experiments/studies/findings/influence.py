"""Which run moves which quantity by more than noise, and where the runs scatter more."""

import dataclasses

import numpy as np
from jaxtyping import Bool

from experiments.page.number_text import plain
from experiments.studies.findings.parameters import estimated
from identification.judge.influence import FEWEST, Influence
from identification.result.estimate import Estimate

DISSENTS = 3.0
"""Times what noise makes of it from which a run's influence is called more than noise [1]."""

WIDER = 1.5
"""Times the reported interval's width from which the bootstrap's is called wider [1]."""

Quantity = tuple[str, str | None]
"""Name and setting of a quantity."""


@dataclasses.dataclass(frozen=True)
class LargestMove:
    """The move of a quantity by leaving out a run that says the most."""

    run: str
    """Name of the run."""
    quantity: Quantity
    """The quantity."""
    move: float
    """By how many of its standard errors it moves [1]."""
    noise: float
    """By how many noise alone would move it [1]."""
    dissents: bool
    """Whether that is more than noise."""


@dataclasses.dataclass(frozen=True)
class InfluenceVerdict:
    """What the influence of the runs comes to."""

    alone: tuple[tuple[str, Quantity], ...]
    """Runs without which nothing tells a quantity, with that quantity."""
    largest: LargestMove
    """The largest move; of those beyond noise where there are any."""
    first_order: bool
    """Whether the moves are steps that may be too short: residuals beyond noise, no new fit."""
    wider: tuple[tuple[Quantity, float], ...]
    """Quantities whose bootstrap interval is wider than the reported one, how many times."""
    too_few: tuple[Quantity, ...]
    """Quantities that too few runs tell for a bootstrap."""


def influence_verdict(estimate: Estimate) -> InfluenceVerdict | None:
    """What the influence of the runs comes to.

    Args:
        estimate: The estimate.

    Returns:
        The verdict; None where nothing was estimated from more than one run.
    """
    influence = estimate.influence
    if len(influence.runs) < 2 or not influence.names:
        return None
    noise = all(c.is_noise for run in estimate.comparisons for c in run.channels)
    shown = has_error(influence)
    return InfluenceVerdict(
        alone=tuple(
            (run, name)
            for run, values in zip(influence.runs, influence.without, strict=True)
            for name, untold in zip(influence.names, np.isnan(values), strict=True)
            if untold
        ),
        largest=_largest(influence),
        first_order=not (noise or influence.refitted),
        wider=_wider(estimate),
        too_few=tuple(
            name
            for name, interval, measured in zip(
                influence.names, influence.interval95, shown, strict=True
            )
            if interval is None and measured
        ),
    )


def has_error(influence: Influence) -> Bool[np.ndarray, " quantities"]:
    """Which quantities have a standard error to measure a move by.

    Args:
        influence: The influence of the runs.

    Returns:
        Whether each does.
    """
    return ~np.all(np.isnan(influence.moved), axis=0)


def _largest(influence: Influence) -> LargestMove:
    size = np.nan_to_num(np.abs(influence.moved))
    more = size > DISSENTS * np.nan_to_num(influence.by_noise, nan=np.inf)
    dissent = np.where(more & (size > 1), size, 0.0)
    dissents = bool(dissent.any())
    row, column = np.unravel_index(np.argmax(dissent if dissents else size), size.shape)
    return LargestMove(
        run=influence.runs[row],
        quantity=influence.names[column],
        move=float(influence.moved[row, column]),
        noise=float(influence.by_noise[row, column]),
        dissents=dissents,
    )


def _wider(estimate: Estimate) -> tuple[tuple[Quantity, float], ...]:
    wider = []
    for p, interval in zip(estimated(estimate), estimate.influence.interval95, strict=True):
        reported = p.interval95[1] - p.interval95[0]
        if interval is not None and interval[1] - interval[0] > WIDER * reported:
            wider.append(((p.name, p.setting), (interval[1] - interval[0]) / reported))
    return tuple(wider)


FIRST_ORDER = (
    "The residuals are more than noise: leaving a run out also changes how much the other "
    "channels count, so that these steps may be half of what a fit without the run gives. "
    "`scdpr identify --leave-out` fits anew without each run."
)


def influence_sentences(verdict: InfluenceVerdict | None) -> tuple[str, ...]:
    """What the runs' influence says, in words.

    Args:
        verdict: The verdict on it; None for a single run.

    Returns:
        Sentences.
    """
    if verdict is None:
        return ("A single run was fitted: there is none to leave out or to draw anew.",)
    lines = [
        f"Without {run} nothing tells the {shown_quantity(name)}."
        for run, name in verdict.alone
    ]
    lines.append(_largest_sentence(verdict.largest))
    if verdict.first_order:
        lines.append(FIRST_ORDER)
    if verdict.wider:
        listed = ", ".join(
            f"{shown_quantity(name)} {plain(times, 2)} times" for name, times in verdict.wider
        )
        lines.append(
            "Drawn anew the runs scatter by more than the reported intervals say: "
            f"{listed} as wide. Other runs of the same kinds may give values as far "
            "apart."
        )
    if verdict.too_few:
        listed = ", ".join(map(shown_quantity, verdict.too_few))
        lines.append(
            f"Too few runs for a bootstrap of {listed}: it takes {FEWEST:g} that tell a "
            "quantity about equally well. Log more runs of the kinds that tell it."
        )
    return tuple(lines)


def _largest_sentence(largest: LargestMove) -> str:
    told = (
        f"Without {largest.run} the {shown_quantity(largest.quantity)} would be "
        f"{plain(abs(largest.move), 2)} standard errors "
        f"{'larger' if largest.move > 0 else 'smaller'}, "
        f"where noise alone makes {plain(largest.noise, 2)}"
    )
    if largest.dissents:
        return (
            f"{told}: that run says something else than the others do. Look at its residuals, "
            "or fit without it."
        )
    return f"No run moves a quantity by more than noise explains. The most: {told}."


def shown_quantity(name: Quantity) -> str:
    """A quantity's name in words, with its setting.

    Args:
        name: Name and setting.

    Returns:
        "effective pretension 350 N".
    """
    return name[0].replace("_", " ") + (f" {name[1]}" if name[1] else "")
