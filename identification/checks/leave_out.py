"""Fits without each run: what `identification.judge.influence` has to first order."""

import dataclasses

import numpy as np

from identification.campaign.types import Campaign
from identification.judge.influence import decoded, standard_errors
from identification.result.estimate import Estimate
from identification.result.estimation import solved
from scdpr_jax.numerics.progress import SILENT, Progress, listening


def without_each_run(
    campaign: Campaign, estimate: Estimate, *, progress: Progress | bool = SILENT
) -> Estimate:
    """The estimate with its runs left out by fits instead of by a Gauss-Newton step each.

    Args:
        campaign: The campaign that the estimate is of.
        estimate: The estimate.
        progress: Told what is being done and which share of it is done;
            True shows it in a notebook.

    Returns:
        The estimate, `influence` with what the fits gave; its bootstrap as it was.
    """
    progress = listening(progress)
    parameters, influence = estimate.fitted.estimated, estimate.influence
    problem, point = solved(campaign, estimate)
    names = [p.name for p in parameters]
    ends = []
    for number, run in enumerate(problem.fitted()):
        progress(f"without {problem.logs.runs[run].name}", number / len(influence.runs))
        rest = dataclasses.replace(problem, held_out=problem.held_out | {run})
        # What only this run told apart leaves a flat valley: many iterations.
        ends.append(rest.minimise(point, iterations=40, decrement=1e-3).point[: len(names)])
    (value,) = decoded(names, point[None, : len(names)])
    without = np.where(np.isnan(influence.without), np.nan, decoded(names, np.array(ends)))
    moved = (without - value) / standard_errors(parameters)
    return dataclasses.replace(
        estimate,
        influence=dataclasses.replace(influence, without=without, moved=moved, refitted=True),
    )
