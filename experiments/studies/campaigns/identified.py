"""A campaign's parameters with whatever was asked for besides."""

import dataclasses
from typing import Any, NamedTuple

import numpy as np

from identification.campaign.types import Campaign
from identification.checks.leave_out import without_each_run
from identification.checks.posterior import posterior as sampled
from identification.checks.profile import profile as traced_profiles
from identification.checks.selection import select
from identification.fit.unknowns.measured_text import parse_measured
from identification.fit.unknowns.options import DEFAULT_FREE, FitOptions
from identification.judge.likelihood import Posterior, Profile
from identification.result.estimate import Estimate
from identification.result.estimation import estimate
from scdpr_jax.numerics.progress import SILENT, Progress


@dataclasses.dataclass(frozen=True)
class Question:
    """What is asked of a campaign, as the command line has it."""

    free: tuple[str, ...] = ()
    """Quantities to estimate; none for the usual ones, and what explains the rest best."""
    hold_out: tuple[str, ...] = ()
    """Runs to predict instead of fitting them."""
    measured: tuple[str, ...] = ()
    """What was measured otherwise, as text."""
    camera_drifts: bool = False
    """Whether the cameras' clocks may drift."""
    profile: bool = False
    """Whether to trace the misfit along every quantity."""
    leave_out: bool = False
    """Whether to fit anew without each run."""
    posterior: bool = False
    """Whether to sample what the logs leave possible."""

    @property
    def options(self) -> FitOptions:
        """What the fit is asked for.

        Raises:
            ValueError: If what was measured can't be read.
        """
        return FitOptions(
            free=self.free or DEFAULT_FREE,
            hold_out=self.hold_out,
            measured=tuple(map(parse_measured, self.measured)),
            clock_drifts=self.camera_drifts,
        )

    @classmethod
    def of(cls, facts: dict[str, Any]) -> "Question":
        """A question from what JSON has of it."""
        lists = {name: tuple(own) for name, own in facts.items() if isinstance(own, list)}
        return cls(**{**facts, **lists})


class Identified(NamedTuple):
    """What a campaign says."""

    estimate: Estimate
    """The parameters."""
    profiles: tuple[Profile, ...]
    """Their profiles; none where they weren't asked for."""
    posterior: Posterior | None
    """What the logs leave possible; None where it wasn't asked for."""


def identified(
    campaign: Campaign, question: Question, *, progress: Progress = SILENT
) -> Identified:
    """A campaign's parameters, and what else was asked for.

    Args:
        campaign: The campaign as a fit should see it.
        question: What is asked.
        progress: Told what is being done and which share of it is done.

    Returns:
        The answer.

    Raises:
        ValueError: If the campaign doesn't allow a fit, or numpyro is missing.
        FloatingPointError: If a run's simulation isn't finite.
    """
    # A profile takes as long as a fit, a fit without each run twice, draws ten times.
    costs = [1.0, 1.0 * question.profile, 2.0 * question.leave_out, 10.0 * question.posterior]
    ends = np.cumsum([0.0, *costs]) / sum(costs)
    fitting, profiling, leaving, drawing = map(progress.part, ends[:-1], ends[1:])
    fit = estimate if question.free else select
    fitted = fit(campaign, question.options, progress=fitting)
    profiling("profiles" if question.profile else "", 0.0)
    traced = tuple(traced_profiles(campaign, fitted)) if question.profile else ()
    if question.leave_out:
        fitted = without_each_run(campaign, fitted, progress=leaving)
    drawn = sampled(campaign, fitted, progress=drawing) if question.posterior else None
    return Identified(fitted, traced, drawn)
