r"""What logs can tell of which quantity, before a fit and after it.

With the residuals' Jacobian $J$ in units of the noise, $J^T J$ is Fisher's information. What
each run's circumstances share with the quantities is taken off by the Schur complement; the
eigenvectors of what is left are the combinations of quantities that the logs tell, and the
small eigenvalues those that they don't. What the rank leaves open is told apart from what the
noise hides: a combination that moves less than a thousandth of the motion over all that is
plausible of it isn't told by any sensor, since the model itself is no better than that.
"""

import dataclasses
import math
from collections.abc import Iterable, Mapping

import numpy as np
from jaxtyping import Float

from identification.fit.comparison import ENCODERS, Comparison
from identification.fit.problem import Problem
from identification.fit.run_sums import RunSums
from identification.fit.unknowns.unknowns import decode
from identification.judge.uncertainty import USUAL, magnitude
from identification.sensitivity.combinations import (
    DETERMINED,
    SHARE,
    Combination,
    combinations,
    named,
)
from scdpr_jax.robot.quantities import quantity

SENSORS = ("encoders", "camera")
"""Groups of channels in the table of `Identifiability.moved`."""


@dataclasses.dataclass(frozen=True, eq=False)
class Identifiability:
    """What logs can tell of the free quantities of a robot."""

    names: tuple[tuple[str, str | None], ...]
    """Name and setting of each free quantity."""
    runs: tuple[str, ...]
    """Names of the runs."""
    moved: Float[np.ndarray, "runs 2 quantities"]
    """By how many of the noise's standard deviations, all samples together, 1 % of each
    quantity (of its size, for one that may be zero) moves each run's encoders and camera."""
    alone: Float[np.ndarray, " quantities"]
    """Relative standard error of each quantity if the others were known [1]."""
    together: Float[np.ndarray, " quantities"]
    """The same with all of them unknown; infinite for what the logs don't tell [1]."""
    combinations: tuple[Combination, ...]
    """From the best to the worst told."""
    unranked: tuple[Combination, ...] = ()
    """Those that move next to nothing over all that is plausible of them: the Jacobian's rank
    leaves them open, however small the noise."""
    plausible: tuple[float, ...] = ()
    """What is plausible of each quantity, as a fit holds it; none where nothing is open."""

    @property
    def rank(self) -> int:
        """How many combinations the logs tell."""
        return sum(each.is_told for each in self.combinations)

    def undetermined(self) -> tuple[Combination, ...]:
        """The combinations that the logs don't tell, for their noise or for their rank."""
        noisy = [each for each in self.combinations if not each.is_told]
        words = {each.text() for each in noisy}
        return (*noisy, *(each for each in self.unranked if each.text() not in words))

    @property
    def open_by_rank(self) -> frozenset[tuple[str, str | None]]:
        """Name and setting of the quantities that the rank leaves open."""
        return frozenset(
            name for each in self.unranked for k, name in enumerate(self.names) if each.has(k)
        )

    def left_open(self) -> dict[tuple[str, str | None], float]:
        """By how much the rank leaves each quantity open, as a fit holds it.

        An open combination may be anywhere within what is plausible of it, and takes every
        quantity along that has a part in it: one with a twentieth is known to a twentieth of
        what is plausible, however well its own slope is known.

        Returns:
            Standard deviations by name and setting.
        """
        if not self.unranked:
            return {}
        parts = np.array([each.powers for each in self.unranked])
        parts = np.where(np.abs(parts) > 1e-6, parts, 0.0)  # an eigenvector's rounding
        sizes = np.sqrt(np.sum(np.square(parts), axis=0)) * self.plausible
        return {n: float(s) for n, s in zip(self.names, sizes, strict=True) if s > 0}

    def reason(self, name: str, setting: str | None) -> str:
        """Why a quantity is told badly, in words.

        Args:
            name: Name of the quantity.
            setting: Its nominal pretension, None for one that all settings share.

        Returns:
            A sentence.
        """
        index = self.names.index((name, setting))
        title = named(name, setting)
        moved = self.moved[:, :, index]
        if not np.any(moved > 0):
            return f"Nothing in the logs depends on the {title}."
        strongest = np.unravel_index(np.argmax(moved), moved.shape)
        where = f"{self.runs[strongest[0]]}'s {SENSORS[strongest[1]]}"
        if self.alone[index] >= DETERMINED:
            return (
                f"The {title} hardly moves anything: 1 % of it moves {where} the most, by "
                f"{moved[strongest]:.2g} standard deviations of the noise."
            )
        shared = [each for each in self.undetermined() if each.has(index)]
        if shared:
            return f"The logs can't tell {shared[-1].text()}."
        return (
            f"By the noise alone the {title} would be known to "
            f"{100 * self.together[index]:.2g} %: what leaves it open is the model's own error."
        )


def identifiability(
    problem: Problem,
    point: Float[np.ndarray, " n"],
    of_runs: Mapping[int, RunSums],
    *,
    motion: float,
) -> Identifiability:
    """What the fitted runs of a problem can tell, if the robot is about what a point says.

    Args:
        problem: The problem.
        point: Vector of the fit; before a fit the start that the logs give.
        of_runs: What each fitted run adds there, by its number.
        motion: Root of the sum of squares of all that the fitted runs' channels move, over
            their noise [1].

    Returns:
        What moves what, and which combinations are told.
    """
    unknowns = problem.unknowns
    opened = np.flatnonzero(unknowns.opened)
    size, scale = unknowns.size, _scales(problem, point)
    matrix, moved = np.zeros((size, size)), np.zeros((len(of_runs), 2, size))
    for k, (run, sums) in enumerate(of_runs.items()):
        channels = sums.information
        at = unknowns.of_run(run)[: channels.shape[-1]]
        encoders, camera = channels[: len(ENCODERS)], channels[len(ENCODERS) :]
        np.add.at(matrix, np.ix_(at, at), channels.sum(axis=0) + sums.prior_information)
        for group, of_group in enumerate((encoders, camera)):
            squares = np.diagonal(of_group, axis1=1, axis2=2).sum(axis=0)
            np.add.at(moved[k, group], at, squares)
    otherwise = problem.otherwise(point).matrix
    # No model errs in what was measured otherwise: known well enough, it counts as told.
    known = (motion * SHARE * DETERMINED) ** 2 * otherwise
    plausible = _scales(problem, point, plausible=True)
    ranked = (matrix + known) * np.outer(plausible, plausible)
    matrix = (matrix + otherwise) * np.outer(scale, scale)
    others = np.flatnonzero(unknowns.open_to(problem.fitted()))
    others = others[others >= len(unknowns.shared)]
    names = unknowns.opened_names
    told = combinations(_schur(matrix, opened, others), names)
    with np.errstate(divide="ignore"):
        alone = 1 / np.sqrt(np.diag(matrix)[opened])
    return Identifiability(
        names=names,
        runs=tuple(problem.logs.runs[run].name for run in of_runs),
        moved=0.01 * np.sqrt(moved[:, :, opened]) * scale[opened],
        alone=alone,
        together=_together(told, len(opened)),
        combinations=told,
        unranked=tuple(
            each
            for each in combinations(_schur(ranked, opened, others), names, motion=motion)
            if each.share < SHARE
        ),
        plausible=tuple(plausible[opened].tolist()),
    )


def motion_over_noise(runs: Iterable[Comparison]) -> float:
    """How far the fitted runs' channels move, all samples together, over their noise.

    Args:
        runs: The runs beside their simulations.

    Returns:
        Root of the sum of squares [1].
    """
    return math.sqrt(
        sum(
            channel.count * (channel.motion / channel.sigma) ** 2
            for run in runs
            if not run.held_out
            for channel in run.channels
        )
    )


def _scales(
    problem: Problem, point: Float[np.ndarray, " n"], *, plausible: bool = False
) -> Float[np.ndarray, " n"]:
    """What a relative change of 1 is in each unknown, where it isn't a logarithm.

    Of what may be zero that is its value, or what is negligible of it; all that is plausible
    of it is the value, or its usual size.
    """
    scale = np.ones(problem.unknowns.size)
    for index, (name, _) in enumerate(problem.unknowns.shared):
        if not quantity(name).positive:
            size = magnitude(name, decode(name, point[index])) or 1.0
            scale[index] = max(size, USUAL.get(name, size)) if plausible else size
    return scale


def _schur(
    matrix: Float[np.ndarray, "n n"], kept: np.ndarray, taken: np.ndarray
) -> Float[np.ndarray, "k k"]:
    """Information about some unknowns while others are unknown, too."""
    taken = taken[np.diag(matrix)[taken] > 0]
    across = matrix[np.ix_(kept, taken)]
    size = 1 / np.sqrt(np.diag(matrix)[taken])
    inner = np.linalg.pinv(matrix[np.ix_(taken, taken)] * np.outer(size, size), hermitian=True)
    return matrix[np.ix_(kept, kept)] - (across * size) @ inner @ (across * size).T


def _together(told: tuple[Combination, ...], count: int) -> Float[np.ndarray, " quantities"]:
    """Standard errors of the quantities from those of their combinations."""
    variance = np.zeros(count)
    for combination in told:
        power = np.square(combination.powers)
        # An eigenvector's rounding doesn't make a quantity undetermined.
        has_part = power > 1e-12
        variance[has_part] += power[has_part] * combination.sigma**2
    return np.sqrt(variance)
