"""Which model: what the usual one lacks, by information criteria and held-out runs."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from identification.campaign.types import Campaign
from identification.fit.correction import unweighted
from identification.fit.problem import Problem
from identification.fit.unknowns.models import REFINEMENTS, Model, Refinement
from identification.fit.unknowns.options import FitOptions
from identification.fit.unknowns.unknowns import FOLLOWS, layout
from identification.result.compliance import with_compliance
from identification.result.estimate import Estimate
from identification.result.estimation import estimate, require_float64, solve, vector
from scdpr_jax.numerics.levenberg_marquardt import Minimum, free_unknowns
from scdpr_jax.numerics.merit import Normal
from scdpr_jax.numerics.progress import SILENT, Progress, listening
from scdpr_jax.robot.state import pose

ITERATIONS = 30
"""Most evaluations of a model; the next one goes on from there, and the chosen one, too."""


def select(
    campaign: Campaign,
    options: FitOptions | None = None,
    *,
    refinements: Sequence[Refinement] = REFINEMENTS,
    progress: Progress | bool = SILENT,
) -> Estimate:
    r"""The usual estimate or, where it leaves more than noise, that of a model with more in it.

    Forward selection: of the refinements that aren't in yet, the score test's statistic
    $g^T I^{-1} g$ of each tells how far the misfit would fall, with the gradient $g$ and the
    information $I$ that the present fit leaves open for its quantities. The most promising
    is added and fitted; one that this sends back to its bounds is taken out. Of the models
    on that way the one is chosen that predicts the held-out runs best, or, without any, that
    has the least of Schwarz's criterion.

    Reference: C. R. Rao, "Large sample tests of statistical hypotheses concerning several
    parameters", Math. Proc. Camb. Phil. Soc. 44, 1948, doi:10.1017/S0305004100023987.

    Args:
        campaign: The campaign.
        options: What the fits are asked for, as in `estimate`; `free` is the usual model.
        refinements: What may be added.
        progress: Told what is being done and which share of it is done;
            True shows it in a notebook.

    Returns:
        The chosen model's estimate, with the models that it was chosen from.

    Raises:
        ValueError: If float64 is off, or if a run can't be used.
        FloatingPointError: If a run's simulation isn't finite at a solution.
    """
    progress = listening(progress)
    require_float64()
    options = options or FitOptions()
    usual = estimate(campaign, options, progress=progress.part(0.0, 0.4))
    if all(channel.is_noise for run in usual.comparisons for channel in run.channels):
        return usual
    candidates = [r for r in refinements if not set(r.free) <= set(options.free)]
    every = _with(options, candidates)
    progress("other models", 0.41)  # Most campaigns end before this.
    whole = Problem.of(campaign, dataclasses.replace(options, free=every))
    fits = _forward(
        whole, options, vector(whole, usual), candidates=candidates, progress=progress
    )
    progress("models on the runs held out", 0.85)
    models = _models(whole, fits)
    choice = _choice(models)
    if choice == 0:
        return dataclasses.replace(usual, models=models)
    best = fits[choice]
    chosen = solve(
        best.problem,
        [best.minimum.point],
        valleys=usual.fit.valleys,
        progress=progress.part(0.9, 1.0),
    )
    chosen = dataclasses.replace(chosen, models=models, choice=choice)
    return with_compliance(chosen, campaign)


@dataclasses.dataclass(frozen=True, eq=False)
class _Fit:
    """A fitted model."""

    added: tuple[Refinement, ...]
    problem: Problem
    minimum: Minimum
    point: Float[np.ndarray, " whole"]


def _forward(
    whole: Problem,
    usual: FitOptions,
    point: Float[np.ndarray, " whole"],
    *,
    candidates: Sequence[Refinement],
    progress: Progress,
) -> list[_Fit]:
    """The usual model and those that adding the most promising refinement leads to."""
    remaining, added = list(candidates), []
    fits: list[_Fit] = []
    while True:
        progress(f"model {len(fits) + 1}", 0.41 + 0.39 * len(fits) / (len(candidates) + 1))
        problem = _opened(whole, usual, added)
        minimum = problem.minimise(
            _picked(whole, problem, point), iterations=ITERATIONS, decrement=0.1
        )
        point = _embedding(whole, problem) @ minimum.point
        if len(kept := _needed(problem, minimum, added)) < len(added):
            added, problem = kept, _opened(whole, usual, kept)
            minimum = problem.minimise(
                _picked(whole, problem, point), iterations=2, decrement=1.0
            )
        if not fits or tuple(added) != fits[-1].added:
            fits.append(_Fit(tuple(added), problem, minimum, point))
        promised = _promises(whole, problem, point, remaining)
        if not promised or max(promised) <= 0:
            return fits
        added.append(remaining.pop(int(np.argmax(promised))))


def _with(usual: FitOptions, added: Sequence[Refinement]) -> tuple[str, ...]:
    """Names of the quantities that the usual model frees together with some refinements."""
    return tuple(dict.fromkeys((*usual.free, *(name for r in added for name in r.free))))


def _opened(whole: Problem, usual: FitOptions, added: Sequence[Refinement]) -> Problem:
    """The whole problem with only the usual and the added quantities free."""
    unknowns = layout(
        whole.logs.runs,
        whole.unknowns.free,
        opened=dataclasses.replace(usual, free=_with(usual, added)).all_free,
        clock_drifts=usual.clock_drifts,
    )
    return dataclasses.replace(whole, unknowns=unknowns)


def _needed(
    problem: Problem, minimum: Minimum, added: Sequence[Refinement]
) -> list[Refinement]:
    """Those of the added refinements that later ones haven't sent back to their bounds."""
    moves = free_unknowns(minimum.normal, minimum.point, problem.unknowns.lower())
    names = {name for k, (name, _) in enumerate(problem.unknowns.shared) if moves[k]}
    return [refinement for refinement in added if names.intersection(refinement.free)]


def _embedding(whole: Problem, part: Problem) -> Float[np.ndarray, "whole part"]:
    """What each unknown of a part is in the whole, where nothing follows anything."""
    matrix = np.zeros((whole.unknowns.size, part.unknowns.size))
    for index, (name, setting) in enumerate(whole.unknowns.shared):
        is_there = (name, setting) in part.unknowns.shared
        matrix[index, part.unknowns.place(name if is_there else FOLLOWS[name], setting)] = 1.0
    circumstances = whole.unknowns.active.size
    matrix[-circumstances:, -circumstances:] = np.eye(circumstances)
    return matrix


def _picked(
    whole: Problem, part: Problem, point: Float[np.ndarray, " whole"]
) -> Float[np.ndarray, " part"]:
    """A vector of the whole problem as one of the part."""
    at = [whole.unknowns.place(*place) for place in part.unknowns.shared]
    return np.concatenate([point[at], point[len(whole.unknowns.shared) :]])


def _promises(
    whole: Problem,
    problem: Problem,
    point: Float[np.ndarray, " whole"],
    remaining: Sequence[Refinement],
) -> list[float]:
    """By how much each refinement promises to lower the misfit, beyond its own price.

    The price is Schwarz's: the measurements' logarithm for each unknown.
    """
    if not remaining:
        return []
    (normal,) = whole.evaluate([point])
    is_free = free_unknowns(normal, point, whole.unknowns.lower())
    every = range(len(whole.logs.runs))
    base = _embedding(whole, problem)[:, problem.unknowns.open_to(every)]
    seen = base.T @ normal.matrix @ base
    base = base[:, np.diag(seen) > 0]
    promised = []
    for refinement in remaining:
        at = [
            index
            for index, (name, _) in enumerate(whole.unknowns.shared)
            if name in refinement.free and is_free[index]
        ]
        price = len(at) * math.log(problem.measurements())
        promised.append(_score(normal, base, at) - price if at else -math.inf)
    return promised


def _score(normal: Normal, base: Float[np.ndarray, "n base"], at: list[int]) -> float:
    """The score test's statistic of some unknowns beside those of a base."""
    across = base.T @ normal.matrix[:, at]
    within = np.linalg.pinv(base.T @ normal.matrix @ base, hermitian=True)
    information = normal.matrix[np.ix_(at, at)] - across.T @ within @ across
    slope = normal.gradient[at] - across.T @ within @ (base.T @ normal.gradient)
    return float(slope @ np.linalg.pinv(information, hermitian=True) @ slope)


def _models(whole: Problem, fits: Sequence[_Fit]) -> tuple[Model, ...]:
    """The fitted models with their criteria, and how they predict the runs held out."""
    held_out = [(None, None)] * len(fits)
    rows = [row for row, run in enumerate(whole.logs.cabled) if run in whole.held_out]
    if rows:
        alone = whole.minimise_on(
            rows, [fit.point for fit in fits], iterations=8, decrement=0.1, shared=False
        )
        held_out = [(end.normal.cost, _path_error(whole, rows, end.point)) for end in alone]
    return tuple(_model(fit, *misses) for fit, misses in zip(fits, held_out, strict=True))


def _path_error(problem: Problem, rows: Sequence[int], point: Float[np.ndarray, " n"]) -> float:
    """Root mean square distance of the end-effector from its prediction in some runs [m]."""
    sums = problem.cabled_sums([point], rows)
    weight = pose(np.asarray(problem.logs.rough.frame_weight)[rows])
    error = unweighted(pose(sums.residuals.frame), weight)
    whole = np.all(weight > 0, axis=2)
    return float(np.sqrt(np.mean(np.sum(np.square(error), axis=2)[whole])))


def _model(fit: _Fit, held_out: float | None, error: float | None) -> Model:
    problem, minimum = fit.problem, fit.minimum
    measured, cost = problem.measurements(), minimum.normal.cost
    is_free = free_unknowns(minimum.normal, minimum.point, problem.unknowns.lower())
    unknowns = int(np.sum(is_free))
    return Model(
        added=tuple(refinement.lacks for refinement in fit.added),
        free=tuple(dict.fromkeys(name for name, _ in problem.unknowns.opened_names)),
        misfit=cost / measured,
        aic=cost + 2 * unknowns,
        bic=cost + unknowns * math.log(measured),
        held_out=held_out,
        path_error=error,
    )


def _choice(models: Sequence[Model]) -> int:
    """The model that predicts the held-out runs best, else the one of the least criterion."""
    if models[0].held_out is not None:
        return int(np.argmin([model.held_out for model in models]))
    return int(np.argmin([model.bic for model in models]))
