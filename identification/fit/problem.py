"""What a fit minimises: a campaign's normal equations over one vector of unknowns.

The misfit is a sum over the runs, each of which knows the shared quantities and its own
circumstances alone. So a run's Jacobian is made over these few columns, and its sums are added
into the whole at their places. What was measured otherwise adds residuals of its own.
"""

import dataclasses
from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from identification.campaign.types import Campaign
from identification.data.beginning import drive_speeds
from identification.data.circumstances import NAMES, START, TURNING_DRIVES
from identification.data.record import Record
from identification.fit.lanes import LANES, Result, RunFunction, in_lanes
from identification.fit.logs import Logs
from identification.fit.residuals import Predicted, predicted
from identification.fit.run_sums import RunSums, assemble, motor_sums, run_sums
from identification.fit.unknowns.measured import pulls, require_settings
from identification.fit.unknowns.options import FitOptions
from identification.fit.unknowns.unknowns import Unknowns, layout, start_values
from scdpr_jax.numerics.levenberg_marquardt import (
    Minimum,
    Stopping,
    minimise,
    minimise_together,
)
from scdpr_jax.numerics.merit import Normal
from scdpr_jax.numerics.progress import SILENT, Progress
from scdpr_jax.robot.parameters import Robot

MOTOR_LANES = 2
"""Runs of the bare drives that are simulated in a chunk: a campaign has few."""


@dataclasses.dataclass(frozen=True, eq=False)
class Problem:
    """A campaign prepared for fitting."""

    logs: Logs
    """The runs as arrays."""
    options: FitOptions
    """What the fit is asked for."""
    prior: Robot
    """The robot with what isn't free, and the start of what is."""
    unknowns: Unknowns
    """The layout of the fit's vector."""
    held_out: frozenset[int]
    """Numbers of the runs that say nothing about the shared quantities."""

    @classmethod
    def of(cls, campaign: Campaign, options: FitOptions) -> "Problem":
        """The problem of a campaign.

        Args:
            campaign: The campaign.
            options: What the fit is asked for.

        Returns:
            The problem.

        Raises:
            ValueError: If a name is unknown, nothing tells where a run started, or
                something was measured at a setting that no run has.
        """
        runs, drifts = campaign.runs, options.clock_drifts
        held_out = frozenset(runs.index(campaign.run(name)) for name in options.hold_out)
        prior = options.prior(campaign)
        logs = Logs.of(campaign, prior, clock_drifts=drifts)
        settings = [runs[i].pretension_label for i in logs.cabled]
        require_settings(options.measured, settings)
        unknowns = layout(runs, options.all_free, clock_drifts=drifts)
        return cls(logs, options, prior, unknowns, held_out)

    def at_rest(self) -> Float[np.ndarray, " n"]:
        """The point of the prior robot, every run starting where and as it was seen to."""
        unknowns = self.unknowns
        point = np.zeros(unknowns.size)
        point[: len(unknowns.shared)] = start_values(self.prior, unknowns)
        for row, run in enumerate(self.logs.cabled):
            places, expected = unknowns.circumstances(run), self.logs.records.prior.mean[row]
            point[places[START]] = expected[START]
            # Where no run begins in motion, there is nothing beyond the usual circumstances.
            point[places[len(NAMES) :]] = expected[len(NAMES) :]
        for run in self.logs.motors:
            if self.logs.runs[run].in_motion:
                speeds = drive_speeds(self.logs.runs[run], self.logs.sensors).value
                for name, speed in zip(TURNING_DRIVES, speeds, strict=True):
                    point[unknowns.circumstance(run, name)] = speed
        return point

    def fitted(self) -> list[int]:
        """Numbers of the runs that say something about the shared quantities."""
        runs = (*self.logs.cabled, *self.logs.motors)
        return [run for run in runs if run not in self.held_out]

    def measurements(self) -> float:
        """How many independent measurements there are, in the fitted runs and otherwise."""
        count = float(len(self.options.measured))
        return count + sum(self.logs.measurements(run) for run in self.fitted())

    def in_lanes(
        self,
        function: RunFunction[Result],
        points: Sequence[Float[np.ndarray, " n"]],
        rows: Sequence[int],
        *,
        records: Record,
        size: int = LANES,
    ) -> Result:
        """A function of runs with the cable on, each at a point, side by side.

        Args:
            function: What to compute of a run.
            points: Vectors of the fit.
            rows: The run at each of them: a row of the records.
            records: `logs.records`, or `logs.rough` of the same runs.
            size: Runs that are compiled for and simulated in one chunk.

        Returns:
            The results, stacked.
        """
        pairs = zip(points, rows, strict=True)
        vectors = [x[self.unknowns.of_run(self.logs.cabled[row])] for x, row in pairs]
        free = self.unknowns.free
        return in_lanes(function, self.prior, free, np.stack(vectors), rows, records, size=size)

    def cabled_sums(
        self, points: Sequence[Float[np.ndarray, " n"]], rows: Sequence[int]
    ) -> RunSums:
        """What some runs with the cable on add at each of some points.

        Args:
            points: Vectors of the fit.
            rows: The rows of `logs.records` to look at.

        Returns:
            The sums of these runs at the first point, then at the next, stacked.
        """
        each, every = [x for x in points for _ in rows], list(rows) * len(points)
        return self.in_lanes(run_sums, each, every, records=self.logs.rough)

    def of_motors(
        self, function: RunFunction[Result], point: Float[np.ndarray, " n"]
    ) -> Result:
        """A function of the runs of the bare drives at a point.

        Args:
            function: What to compute of a run.
            point: Vector of the fit.

        Returns:
            The results of all of them, stacked, as NumPy arrays.
        """
        motors = list(self.logs.motors)
        return in_lanes(
            function,
            self.prior,
            self.unknowns.free,
            np.stack([point[self.unknowns.of_bare(run)] for run in motors]),
            range(len(motors)),
            self.logs.motor_records,
            size=MOTOR_LANES,
        )

    def predictions(
        self, point: Float[np.ndarray, " n"], rows: Sequence[int] | None = None
    ) -> Predicted:
        """What is simulated for the runs with the cable on, on the logs' own grid.

        Args:
            point: Vector of the fit.
            rows: Rows of `logs.records` to look at; None for all.

        Returns:
            As of `identification.fit.residuals.predicted`, stacked.
        """
        rows = range(len(self.logs.cabled)) if rows is None else rows
        return self.in_lanes(predicted, [point] * len(rows), rows, records=self.logs.records)

    def sums(
        self,
        points: Sequence[Float[np.ndarray, " n"]],
        *,
        rows: Sequence[int] | None = None,
        held_out: bool = False,
    ) -> list[dict[int, RunSums]]:
        """What runs add at each of some points.

        Args:
            points: Vectors of the fit.
            rows: The rows of `logs.records` to look at; None for every fitted run, those of
                the bare drives included.
            held_out: Whether to look at the runs held out instead of at the fitted ones.

        Returns:
            For each point the sums of each run by its number, those with the cable on first.
        """
        logs, bare = self.logs, []
        if rows is None:
            rows = [k for k, i in enumerate(logs.cabled) if (i in self.held_out) == held_out]
            bare = [k for k, i in enumerate(logs.motors) if (i in self.held_out) == held_out]
        sums: list[dict[int, RunSums]] = [{} for _ in points]
        if rows:
            stacked = self.cabled_sums(points, rows)
            for k, of_point in enumerate(sums):
                for j, row in enumerate(rows):
                    of_point[logs.cabled[row]] = _row(stacked, k * len(rows) + j)
        if bare:
            for point, of_point in zip(points, sums, strict=True):
                stacked = self.of_motors(motor_sums, point)
                of_point |= {logs.motors[k]: _row(stacked, k) for k in bare}
        return sums

    def evaluate(
        self,
        points: Sequence[Float[np.ndarray, " n"]],
        *,
        rows: Sequence[int] | None = None,
        held_out: bool = False,
        shared: bool = True,
    ) -> list[Normal]:
        """Normal equations of the fitted runs, of some, or of those held out, at some points.

        Args:
            points: Vectors of the fit.
            rows: The rows of `logs.records` to look at; None for every fitted run.
            held_out: Whether to look at the runs held out instead of at the fitted ones.
            shared: Whether the shared quantities are open, and with them what was measured
                otherwise counts, or the circumstances alone.

        Returns:
            One for each point, over all unknowns.
        """
        each = [
            assemble(self.unknowns, of_point, shared=shared)[0]
            for of_point in self.sums(points, rows=rows, held_out=held_out)
        ]
        if not shared:
            return each
        return [runs.plus(self.otherwise(x)) for runs, x in zip(each, points, strict=True)]

    def otherwise(self, point: Float[np.ndarray, " n"]) -> Normal:
        """The normal equations of what was measured otherwise.

        Args:
            point: Vector of the fit.

        Returns:
            Normal equations over all unknowns.
        """
        size = self.unknowns.size
        normal = Normal(0.0, np.zeros(size), np.zeros((size, size)))
        if not self.options.measured:
            return normal
        at, free = self.measured_places(), self.unknowns.free
        both = pulls(self.options.measured, self.prior, free, jnp.asarray(point[at]))
        pull, slopes = (np.asarray(part) for part in both)
        # Quantities that share an unknown add up in it.
        jacobian = np.zeros((len(pull), size))
        np.add.at(jacobian, (np.arange(len(pull))[:, None], at), slopes)
        jacobian[:, : self.unknowns.opened.size] *= self.unknowns.opened
        return Normal(float(pull @ pull), jacobian.T @ pull, jacobian.T @ jacobian)

    def measured_places(self) -> Int[np.ndarray, "numbers names"]:
        """Where the free quantities of what was measured otherwise stand in the fit's vector.

        Returns:
            Indices of those at each number's setting.
        """
        runs = self.logs.runs

        def at(setting: str | None) -> np.ndarray:
            for run in self.logs.cabled:
                if setting in (None, runs[run].pretension_label):
                    return self.unknowns.local[run]
            return self.unknowns.local[0]

        return np.stack([at(number.setting) for number in self.options.measured])

    def compile(self) -> None:
        """Compiles what a fit needs, by a chunk of each."""
        point = self.at_rest()
        if self.logs.records is not None:
            self.cabled_sums([point], [0])
            self.predictions(point, [0])
        if self.logs.motor_records is not None:
            self.of_motors(motor_sums, point)

    def minimise(
        self,
        start: Float[np.ndarray, " n"],
        *,
        iterations: int,
        decrement: float,
        progress: Progress = SILENT,
        held_out: bool = False,
    ) -> Minimum:
        """The minimum that a start leads to, on the coarser grid.

        Args:
            start: Vector of the fit.
            iterations: Most evaluations.
            decrement: Decrease of the misfit that a step still has to promise.
            progress: Told which share of the evaluations has been made.
            held_out: Whether to fit the held-out runs' circumstances, and nothing else.

        Returns:
            Where it ended.
        """
        return minimise(
            lambda point: self.evaluate([point], held_out=held_out, shared=not held_out)[0],
            start,
            lower=self.unknowns.lower(),
            longest=self.unknowns.longest(),
            stopping=Stopping(evaluations=iterations, decrement=decrement),
            progress=progress,
        )

    def minimise_on(
        self,
        rows: Sequence[int],
        starts: Sequence[Float[np.ndarray, " n"]],
        *,
        iterations: int,
        decrement: float,
        share: float = 1e-6,
        shared: bool = True,
    ) -> list[Minimum]:
        """The minima that several starts lead to, on a few of the runs and side by side.

        Args:
            rows: Rows of `logs.records` to fit.
            starts: Vectors of the fit.
            iterations: Most evaluations of each.
            decrement: Decrease of the misfit that a step still has to promise.
            share: Share of the misfit that it has to, if that is more.
            shared: Whether the shared quantities are open, or the circumstances alone.

        Returns:
            Where each ended.
        """
        return minimise_together(
            lambda points: self.evaluate(points, rows=rows, shared=shared),
            starts,
            lower=self.unknowns.lower(),
            longest=self.unknowns.longest(),
            stopping=Stopping(evaluations=iterations, decrement=decrement, share=share),
        )


def _row(sums: RunSums, row: int) -> RunSums:
    return jax.tree.map(lambda leaf: leaf[row], sums)
