"""Which model: what the usual one lacks, by information criteria and held-out runs."""

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from identification.campaign.types import Campaign
from identification.fit.levenberg_marquardt import Minimum, Normal, free_unknowns
from identification.fit.problem import Problem
from identification.fit.unknowns.measured import Measured, with_measured
from identification.fit.unknowns.models import REFINEMENTS, Model, Refinement
from identification.fit.unknowns.unknowns import DEFAULT_FREE, FOLLOWS, layout
from identification.result.estimate import Estimate, estimate, require_float64, solve, vector
from scdpr_jax.robot.parameters import exact, replace
from scdpr_jax.robot.prototype import consistent

ITERATIONS = 30
"""Most evaluations of a model; the next one goes on from there, and the chosen one, too."""

Progress = Callable[[str, float], None]


def select(
    campaign: Campaign,
    *,
    hold_out: Sequence[str] = (),
    measured: Sequence[Measured] = (),
    clock_drifts: bool = False,
    refinements: Sequence[Refinement] = REFINEMENTS,
    progress: Progress = lambda doing, share: None,
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
        hold_out: Names of runs that say nothing about the shared quantities.
        measured: What was measured otherwise, as in `estimate`.
        clock_drifts: Whether the cameras' clocks may drift.
        refinements: What may be added.
        progress: Told what is being done and which share of it is done.

    Returns:
        The chosen model's estimate, with the models that it was chosen from.

    Raises:
        ValueError: If float64 is off, or if a run can't be used.
        FloatingPointError: If a run's simulation isn't finite at a solution.
    """
    require_float64()
    usual = estimate(
        campaign,
        hold_out=hold_out,
        measured=measured,
        clock_drifts=clock_drifts,
        progress=lambda doing, share: progress(doing, 0.4 * share),
    )
    if all(channel.is_noise for run in usual.comparisons for channel in run.channels):
        return usual
    every = (*DEFAULT_FREE, *(name for one in refinements for name in one.free))
    prior = exact(replace(consistent(), campaign.robot))
    whole = Problem.of(
        campaign,
        prior,
        every,
        frozenset(hold_out),
        measured=measured,
        clock_drifts=clock_drifts,
    )
    point = vector(whole, usual)
    left, added = list(refinements), []
    fits: list[_Fit] = []
    while True:
        progress(f"model {len(fits) + 1}", 0.4 + 0.4 * len(fits) / (len(refinements) + 1))
        problem = _opened(whole, added)
        minimum = problem.minimise(
            _picked(whole, problem, point), iterations=ITERATIONS, decrement=0.1
        )
        point = _embedding(whole, problem) @ minimum.point
        if len(kept := _needed(problem, minimum, added)) < len(added):
            added, problem = kept, _opened(whole, kept)
            minimum = problem.minimise(
                _picked(whole, problem, point), iterations=2, decrement=1.0
            )
        if not fits or tuple(added) != fits[-1].added:
            fits.append(_Fit(tuple(added), problem, minimum, point))
        promised = _promises(whole, problem, point, left)
        if not promised or max(promised) <= 0:
            break
        added.append(left.pop(int(np.argmax(promised))))
    progress("models on the runs held out", 0.85)
    models = _models(whole, fits)
    choice = _choice(models)
    if choice == 0:
        return dataclasses.replace(usual, models=models)
    best = fits[choice]
    chosen = solve(
        best.problem,
        [best.minimum.point],
        campaign=campaign,
        valleys=usual.fit.valleys,
        progress=lambda doing, share: progress(doing, 0.9 + 0.1 * share),
    )
    return dataclasses.replace(chosen, models=models, choice=choice)


class _Fit(NamedTuple):
    """A fitted model."""

    added: tuple[Refinement, ...]
    problem: Problem
    minimum: Minimum
    point: Float[np.ndarray, " whole"]


def _opened(whole: Problem, added: Sequence[Refinement]) -> Problem:
    """The whole problem with only the usual and the added quantities free."""
    added_free = (*DEFAULT_FREE, *(name for one in added for name in one.free))
    free = with_measured(added_free, whole.measured)
    unknowns = layout(whole.runs, whole.unknowns.free, opened=free)
    same = dataclasses.replace(unknowns, active=whole.unknowns.active)
    return dataclasses.replace(whole, unknowns=same)


def _needed(
    problem: Problem, minimum: Minimum, added: Sequence[Refinement]
) -> list[Refinement]:
    """Those of the added refinements that later ones haven't sent back to their bounds."""
    moves = free_unknowns(minimum.normal, minimum.point, problem.unknowns.lower())
    names = {name for k, (name, _) in enumerate(problem.unknowns.shared) if moves[k]}
    return [one for one in added if names.intersection(one.free)]


def _embedding(whole: Problem, part: Problem) -> Float[np.ndarray, "whole part"]:
    """What each unknown of a part is in the whole, where nothing follows anything."""
    matrix = np.zeros((whole.unknowns.size, part.unknowns.size))
    for index, (name, setting) in enumerate(whole.unknowns.shared):
        known = (name, setting) in part.unknowns.shared
        same = (name if known else FOLLOWS[name], setting)
        matrix[index, part.unknowns.shared.index(same)] = 1.0
    own = whole.unknowns.active.size
    matrix[-own:, -own:] = np.eye(own)
    return matrix


def _picked(
    whole: Problem, part: Problem, point: Float[np.ndarray, " whole"]
) -> Float[np.ndarray, " part"]:
    """A vector of the whole problem as one of the part."""
    at = [whole.unknowns.shared.index(one) for one in part.unknowns.shared]
    return np.concatenate([point[at], point[len(whole.unknowns.shared) :]])


def _promises(
    whole: Problem,
    problem: Problem,
    point: Float[np.ndarray, " whole"],
    left: Sequence[Refinement],
) -> list[float]:
    """By how much each refinement promises to lower the misfit, beyond its own price.

    The price is Schwarz's: the measurements' logarithm for each unknown.
    """
    if not left:
        return []
    (normal,) = whole.evaluate([point])
    open_ones = free_unknowns(normal, point, whole.unknowns.lower())
    base = _embedding(whole, problem)[:, _active(problem)]
    seen = base.T @ normal.matrix @ base
    base = base[:, np.diag(seen) > 0]
    found = []
    for one in left:
        at = [
            index
            for index, (name, _) in enumerate(whole.unknowns.shared)
            if name in one.free and open_ones[index]
        ]
        price = len(at) * math.log(problem.measurements())
        found.append(_score(normal, base, at) - price if at else -math.inf)
    return found


def _active(problem: Problem) -> Int[np.ndarray, " active"]:
    """Unknowns of a problem that its fit may change."""
    shared = np.flatnonzero(problem.unknowns.opened)
    own = len(problem.unknowns.shared) + np.flatnonzero(problem.unknowns.active.ravel())
    return np.concatenate([shared, own])


def _score(normal: Normal, base: Float[np.ndarray, "n base"], at: list[int]) -> float:
    """The score test's statistic of some unknowns beside those of a base."""
    across = base.T @ normal.matrix[:, at]
    within = np.linalg.pinv(base.T @ normal.matrix @ base, hermitian=True)
    open_to_it = normal.matrix[np.ix_(at, at)] - across.T @ within @ across
    slope = normal.gradient[at] - across.T @ within @ (base.T @ normal.gradient)
    return float(slope @ np.linalg.pinv(open_to_it, hermitian=True) @ slope)


def _models(whole: Problem, fits: Sequence[_Fit]) -> tuple[Model, ...]:
    """The fitted models with their criteria, and how they predict the runs held out."""
    held_out = [(None, None)] * len(fits)
    rows = [row for row, run in enumerate(whole.cabled) if run in whole.held_out]
    if rows:
        alone = whole.minimise_on(
            rows, [fit.point for fit in fits], iterations=8, decrement=0.1, shared=False
        )
        held_out = [(end.normal.cost, whole.path_error(end.point)) for end in alone]
    return tuple(_model(fit, *own) for fit, own in zip(fits, held_out, strict=True))


def _model(fit: _Fit, held_out: float | None, error: float | None) -> Model:
    added, problem, minimum, _ = fit
    measured, cost = problem.measurements(), minimum.normal.cost
    open_ones = free_unknowns(minimum.normal, minimum.point, problem.unknowns.lower())
    unknowns = int(np.sum(open_ones))
    opened = np.flatnonzero(problem.unknowns.opened)
    return Model(
        added=tuple(one.lacks for one in added),
        free=tuple(dict.fromkeys(problem.unknowns.shared[k][0] for k in opened)),
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
