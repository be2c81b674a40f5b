"""A campaign prepared for fitting: its runs as arrays, and their normal equations."""

import dataclasses
from collections.abc import Callable, Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from identification.campaign.types import Campaign, Run
from identification.data.record import Record, coarse, motor_record, stacked, windowed
from identification.data.start import Clock, clocks
from identification.fit.accumulate import MotorRecord, RunSums, assemble, motor_sums, run_sums
from identification.fit.comparison import Predicted, predictions
from identification.fit.lanes import in_lanes
from identification.fit.levenberg_marquardt import Minimum, Normal, minimise, minimise_together
from identification.fit.unknowns.measured import (
    Measured,
    pulls,
    require_settings,
    with_measured,
)
from identification.fit.unknowns.unknowns import Unknowns, layout, start_values
from scdpr_jax.numerics.side_by_side import CORES
from scdpr_jax.robot.parameters import Robot, value

COARSE_STEP = 1e-2
"""Step that Jacobians are made at [s]: a tenth of the fastest vibration, where the engine's
own error is some 1 µm."""


@dataclasses.dataclass(frozen=True, eq=False)
class Problem:
    """A campaign prepared for fitting; `rough` is what is minimised, `records` is exact."""

    runs: tuple[Run, ...]
    """All runs."""
    prior: Robot
    """The robot with what isn't free, and the start of what is."""
    unknowns: Unknowns
    """The layout of the fit's vector."""
    held_out: frozenset[int]
    """Numbers of the runs that say nothing about the shared quantities."""
    cabled: tuple[int, ...]
    """Numbers of the runs with the cable on, in the order of `records`."""
    clocks: tuple[Clock, ...]
    """What is known of the camera's clock in each of those."""
    records: Record | None
    """The runs with the cable on, on the logs' own grid; None without any."""
    rough: Record | None
    """The same on a grid of about `COARSE_STEP`."""
    factor: int
    """How many intervals of `records` are one of `rough`."""
    motors: tuple[int, ...]
    """Numbers of the runs of the bare drives."""
    motor_records: MotorRecord | None
    """Those runs; None without any."""
    measured: tuple[Measured, ...] = ()
    """What was measured otherwise."""
    clock_drifts: bool = False
    """Whether the cameras' clocks may drift."""

    @classmethod
    def of(
        cls,
        campaign: Campaign,
        prior: Robot,
        free: Sequence[str],
        hold_out: frozenset[str],
        *,
        measured: Sequence[Measured] = (),
        clock_drifts: bool = False,
    ) -> "Problem":
        """The problem of a campaign.

        Args:
            campaign: The campaign.
            prior: The robot with what isn't free, and the start of what is.
            free: Names of the free quantities, besides those that were measured otherwise.
            hold_out: Names of the runs to hold out.
            measured: What was measured otherwise.
            clock_drifts: Whether the cameras' clocks may drift.

        Returns:
            The problem.

        Raises:
            ValueError: If a name is unknown, nothing tells where a run started, or
                something was measured at a setting that no run has.
        """
        runs, sensors = campaign.runs, campaign.sensors
        held_out = frozenset(runs.index(campaign.run(name)) for name in hold_out)
        motors = tuple(i for i, run in enumerate(runs) if run.kind == "motor_step")
        cabled = tuple(i for i in range(len(runs)) if i not in motors)
        radius = float(value(prior, "effective_radius"))
        known = clocks([runs[i] for i in cabled], sensors, radius)
        height = float(value(prior, "frame_height"))
        records, rough, factor = None, None, 1
        if cabled:
            records = stacked(
                [runs[i] for i in cabled],
                known,
                sensors,
                height=height,
                clock_drifts=clock_drifts,
            )
            duration = np.asarray(records.inputs.duration)
            factor = max(1, round(COARSE_STEP / float(np.median(duration[duration > 0]))))
            rough = coarse(records, factor)
        require_settings(measured, [runs[i].pretension_label for i in cabled])
        return cls(
            runs=runs,
            prior=prior,
            unknowns=layout(runs, with_measured(free, measured), clock_drifts=clock_drifts),
            held_out=held_out,
            cabled=cabled,
            clocks=known,
            records=records,
            rough=rough,
            factor=factor,
            motors=motors,
            motor_records=motor_record([runs[i] for i in motors], sensors) if motors else None,
            measured=tuple(measured),
            clock_drifts=clock_drifts,
        )

    @property
    def lanes(self) -> int:
        """Runs that are simulated in one chunk: every core has one of them to do."""
        return -(-len(self.cabled) // CORES)

    def at_rest(self) -> Float[np.ndarray, " n"]:
        """The point of the prior robot, every run starting where it was seen to."""
        unknowns = self.unknowns
        own = np.zeros(unknowns.active.size)
        point = np.concatenate([start_values(self.prior, unknowns), own])
        for row, run in enumerate(self.cabled):
            point[self.own(run)[:3]] = self.records.known[row, :3]
        return point

    def own(self, run: int) -> np.ndarray:
        """Where a run's circumstances stand in the fit's vector.

        Args:
            run: Number of the run.

        Returns:
            Indices in the order of `Circumstances`.
        """
        return self.unknowns.of_run(run)[len(self.unknowns.free) :]

    def fitted(self) -> list[int]:
        """Numbers of the runs that say something about the shared quantities."""
        return [run for run in (*self.cabled, *self.motors) if run not in self.held_out]

    def measurements(self) -> float:
        """How many independent measurements there are, in the fitted runs and otherwise."""
        count = float(len(self.measured))
        for row, run in enumerate(self.cabled):
            if run not in self.held_out:
                count += float(jnp.sum(self.rough.angle_share[row]))
                count += float(jnp.sum(self.rough.frame_weight[row] > 0))
        for row, run in enumerate(self.motors):
            if run not in self.held_out:
                count += float(jnp.sum(self.motor_records.share[row]))
        return count

    def sums(
        self, points: Sequence[Float[np.ndarray, " n"]], rows: Sequence[int]
    ) -> list[dict[int, RunSums]]:
        """What some runs with the cable on add at each of some points.

        Args:
            points: Vectors of the fit.
            rows: The rows of `records` to look at.

        Returns:
            For each point the sums of each of these runs, by its number.
        """
        whole, runs = self._simulated(points, rows), [self.cabled[row] for row in rows]
        return [
            {run: _row(whole, k * len(runs) + j) for j, run in enumerate(runs)}
            for k in range(len(points))
        ]

    def _simulated(
        self, points: Sequence[Float[np.ndarray, " n"]], rows: Sequence[int]
    ) -> RunSums:
        """The sums of some runs at the first point, then at the next, stacked.

        Points and runs are simulated side by side, so that one compiled function serves
        every use.
        """
        runs = [self.cabled[row] for row in rows]
        return in_lanes(
            run_sums,
            self.prior,
            self.unknowns.free,
            np.stack([x[self.unknowns.of_run(run)] for x in points for run in runs]),
            list(rows) * len(points),
            self.rough,
            size=self.lanes,
        )

    def predictions(
        self, point: Float[np.ndarray, " n"], rows: Sequence[int] | None = None
    ) -> Predicted:
        """What is simulated for the runs with the cable on, on the logs' own grid.

        Args:
            point: Vector of the fit.
            rows: Rows of `records` to look at; None for all.

        Returns:
            As of `identification.fit.comparison.predictions`.
        """
        rows = range(len(self.cabled)) if rows is None else rows
        return in_lanes(
            predictions,
            self.prior,
            self.unknowns.free,
            self.vectors(point)[list(rows)],
            rows,
            self.records,
            size=self.lanes,
        )

    def each(
        self, points: Sequence[Float[np.ndarray, " n"]], *, held_out: bool = False
    ) -> list[dict[int, RunSums]]:
        """What every fitted run, or every one held out, adds at each of some points.

        Args:
            points: Vectors of the fit.
            held_out: Whether to look at the runs held out instead of at the fitted ones.

        Returns:
            For each point the sums of each run by its number, those with the cable on first.
        """
        rows = [k for k, i in enumerate(self.cabled) if (i in self.held_out) == held_out]
        found = self.sums(points, rows) if rows else [{} for _ in points]
        bare = [k for k, i in enumerate(self.motors) if (i in self.held_out) == held_out]
        if bare:
            for point, own in zip(points, found, strict=True):
                sums = self._motor_sums(point)
                own |= {self.motors[k]: _row(sums, k) for k in bare}
        return found

    def _motor_sums(self, point: Float[np.ndarray, " n"]) -> RunSums:
        """What the runs of the bare drives add at a point, stacked."""
        own = jnp.asarray(np.stack([point[self.unknowns.local[i]] for i in self.motors]))
        found = motor_sums(self.prior, self.unknowns.free, own, self.motor_records)
        return jax.tree.map(np.asarray, found)

    def evaluate(
        self, points: Sequence[Float[np.ndarray, " n"]], *, held_out: bool = False
    ) -> list[Normal]:
        """Normal equations of the fitted runs, or of those held out, at some points.

        Args:
            points: Vectors of the fit.
            held_out: Whether to look at the runs held out, whose circumstances alone are
                then open, instead of at the fitted ones.

        Returns:
            One for each point, over all unknowns.
        """
        return self._assembled(points, self.each(points, held_out=held_out), not held_out)

    def _assembled(
        self,
        points: Sequence[Float[np.ndarray, " n"]],
        found: Sequence[dict[int, RunSums]],
        shared: bool,
    ) -> list[Normal]:
        """Normal equations of some runs, with what else is known of what they may say."""
        each = [assemble(self.unknowns, sums, shared=shared)[0] for sums in found]
        if not shared:
            return each
        return [own.plus(self.otherwise(x)) for own, x in zip(each, points, strict=True)]

    def otherwise(self, point: Float[np.ndarray, " n"]) -> Normal:
        """The normal equations of what was measured otherwise.

        Args:
            point: Vector of the fit.

        Returns:
            Normal equations over all unknowns.
        """
        size = self.unknowns.size
        normal = Normal(0.0, np.zeros(size), np.zeros((size, size)))
        if not self.measured:
            return normal
        at, free = self.told_at(), self.unknowns.free
        found = pulls(self.measured, self.prior, free, jnp.asarray(point[at]))
        pull, slopes = (np.asarray(part) for part in found)
        # Quantities that share an unknown add up in it.
        jacobian = np.zeros((len(pull), size))
        np.add.at(jacobian, (np.arange(len(pull))[:, None], at), slopes)
        jacobian[:, : self.unknowns.opened.size] *= self.unknowns.opened
        return Normal(float(pull @ pull), jacobian.T @ pull, jacobian.T @ jacobian)

    def told_at(self) -> Int[np.ndarray, "numbers names"]:
        """Where the free quantities of what was measured otherwise stand in the fit's vector.

        Returns:
            Indices of those at each number's setting.
        """

        def at(setting: str | None) -> np.ndarray:
            for run in self.cabled:
                if setting in (None, self.runs[run].pretension_label):
                    return self.unknowns.local[run]
            return self.unknowns.local[0]

        return np.stack([at(one.setting) for one in self.measured])

    def compile(self) -> None:
        """Compiles what a fit needs, by a chunk of each."""
        point = self.at_rest()
        if self.records is not None:
            self.sums([point], [0])
            self.predictions(point, [0])
        if self.motor_records is not None:
            self._motor_sums(point)

    def minimise(
        self,
        start: Float[np.ndarray, " n"],
        *,
        iterations: int,
        decrement: float,
        report: Callable[[int, float], None] = lambda iteration, cost: None,
        held_out: bool = False,
    ) -> Minimum:
        """The minimum that a start leads to, on the coarser grid.

        Args:
            start: Vector of the fit.
            iterations: Most evaluations.
            decrement: Decrease of the misfit that a step still has to promise.
            report: Told the evaluations so far and the least misfit.
            held_out: Whether to fit the held-out runs' circumstances, and nothing else.

        Returns:
            Where it ended.
        """
        return minimise(
            lambda point: self.evaluate([point], held_out=held_out)[0],
            start,
            lower=self.unknowns.lower(),
            iterations=iterations,
            decrement=decrement,
            report=report,
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
            rows: Rows of `records` to fit.
            starts: Vectors of the fit.
            iterations: Most evaluations of each.
            decrement: Decrease of the misfit that a step still has to promise.
            share: Share of the misfit that it has to, if that is more.
            shared: Whether the shared quantities are open, or the circumstances alone.

        Returns:
            Where each ended.
        """

        def evaluate(points: list[Float[np.ndarray, " n"]]) -> list[Normal]:
            return self._assembled(points, self.sums(points, rows), shared)

        return minimise_together(
            evaluate,
            starts,
            lower=self.unknowns.lower(),
            iterations=iterations,
            decrement=decrement,
            share=share,
        )

    def corrected(self, point: Float[np.ndarray, " n"]) -> "Problem":
        """The problem whose coarser grid has no error of its own about a point.

        What the exact grid and the coarser one predict differently is taken off the
        measurements: deferred correction, which leaves the Jacobians to the coarser grid.

        Args:
            point: Vector of the fit.

        Returns:
            The problem with corrected measurements on the coarser grid.
        """
        if self.records is None:
            return self
        rough = self._simulated([point], range(len(self.cabled)))
        _, angle, frame = self.predictions(point)
        weight = np.square(self.records.angle_weight)
        difference = windowed(weight * (self.records.angle - np.asarray(angle)), self.factor)
        information = np.square(self.rough.angle_weight)
        exact = difference / np.where(information > 0, information, 1.0)
        turned = exact - _over(rough.residuals.angle, self.rough.angle_weight)
        seen = self.rough.frame_weight > 0
        moved = np.where(seen, self.rough.frame - np.asarray(frame), 0.0) - _over(
            rough.residuals.frame, self.rough.frame_weight
        )
        corrected = eqx.tree_at(
            lambda r: (r.angle, r.frame),
            self.rough,
            (self.rough.angle + turned, self.rough.frame + moved),
        )
        return dataclasses.replace(self, rough=corrected)

    def path_error(self, point: Float[np.ndarray, " n"]) -> float:
        """How far the end-effector is from its prediction in the runs held out.

        Args:
            point: Vector of the fit.

        Returns:
            Root mean square distance over the frames that saw it [m]; NaN without any.
        """
        rows = [row for row, run in enumerate(self.cabled) if run in self.held_out]
        sums = self._simulated([point], rows)
        seen = np.asarray(self.rough.frame_weight)[rows][:, :, [0, 4]]
        off = _over(sums.residuals.frame[:, :, [0, 4]], seen)
        whole = np.all(seen > 0, axis=2)
        return float(np.sqrt(np.mean(np.sum(np.square(off), axis=2)[whole])))

    def vectors(self, point: Float[np.ndarray, " n"]) -> Float[np.ndarray, "runs own"]:
        """What a point says of each run with the cable on.

        Args:
            point: Vector of the fit.

        Returns:
            For each its free quantities and circumstances.
        """
        return np.stack([point[self.unknowns.of_run(i)] for i in self.cabled])


def _row(sums: RunSums, row: int) -> RunSums:
    return jax.tree.map(lambda leaf: leaf[row], sums)


def _over(
    residual: Float[np.ndarray, "..."], weight: Float[jax.Array | np.ndarray, "..."]
) -> Float[np.ndarray, "..."]:
    """Residuals in the measurement's own unit; 0 where nothing was measured."""
    weight = np.asarray(weight)
    return np.where(weight > 0, residual / np.where(weight > 0, weight, 1.0), 0.0)
