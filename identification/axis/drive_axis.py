"""Inertia, friction and offset of one motor-driven axis, from its response to its voltage."""

import dataclasses

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from identification.axis.errors import DISAGREEING, Errors, errors
from identification.axis.estimate import (
    DOES_NOT_FIT,
    PARAMETER_NAMES,
    Change,
    DriveAxisEstimate,
)
from identification.axis.horizons import (
    Horizons,
    LogMeanSquares,
    Weighted,
    horizons,
    mean_squares,
)
from identification.axis.inverse_dynamics import check_mass, inverse_dynamics, opposes
from identification.axis.log import AxisLog
from identification.axis.motion import AxisParameters
from identification.axis.pattern_search import Polished, polish
from identification.axis.record import AxisRecord, axis_record
from identification.axis.told import one_way, plausible_sizes, sum_sigma, told
from identification.sensitivity.combinations import Combination
from scdpr_jax.numerics.levenberg_marquardt import Damping, Minimum, Stopping, minimise_together

NOT_EXPLAINED = 0.3
"""Open-loop error over the motion from which a law doesn't fit [1]."""

_HALF_WINDOWS = (3, 10, 30, 100)  # samples: noise decides which is best, so all are starts
_AGREEING = 0.2  # of the merit a sample and horizon: 10 % of the error, before the polish
_DAMPING = Damping(rise=2.0, growth=2.0, least=0.0, most=1e8)
"""Nielsen's: a kink is crossed by a step only a little shorter, or by none."""
_PROMISED = 1e-3
"""Decrease of the merit that a step has to promise [1]: an error twice as large costs 1.4 a
sample, and no parameter moves by more than a twentieth of its white-noise standard error."""
_WEAK = 0.1  # standard error over value, or over what is negligible of it
_NEGLIGIBLE = 0.05  # of what is plausible: below it a friction may as well be zero


def estimate_drive_axis(
    log: AxisLog,
    *,
    gain: float,
    delay_samples: int = 0,
    starts: Float[np.ndarray, "starts parameters"] | None = None,
    names: tuple[str, ...] = PARAMETER_NAMES,
    open_loop_alone: bool = False,
    max_iterations: int = 12,
) -> DriveAxisEstimate:
    r"""Fit $M \ddot q + F_v \dot q + F_c\,\mathrm{Sgn}\,\dot q + o \ni g u$ to a log.

    The axis is simulated from the voltage: open loop over the whole record, started at the
    first sample, and over shorter horizons, restarted from what was measured
    (`identification.axis.horizons`). That asks more than a balance of forces does (in closed
    loop the position hardly depends on the parameters), and it gives what predicts best.

    The search starts from inverse-dynamics fits at several smoothings, so it needs no
    tuning, and goes by exact gradients (Levenberg–Marquardt). The error has kinks where
    the axis only just stops or doesn't, and its minimum is likely to lie on one: the best
    start is polished by a search that needs no gradient.

    Standard errors are robust to correlated residuals and widened by what horizons and halves
    of the record disagree by (`identification.axis.errors`): what four parameters leave over
    is mostly the axis's own departure from the law, not noise. Whether a parameter is told at
    all is a matter of rank (`identification.axis.told`).

    Args:
        log: The axis's log.
        gain: Force per volt $g$ [N/V], of either sign; [N m/V] for a rotary axis.
        delay_samples: Samples by which the voltage acts late. The default suits a log of
            what was applied. It isn't estimated: in the EMPS axis's record one sample more
            makes the best open loop 0.7 % worse, in the published parameters' 0.1 %.
        starts: Starts of the search in the order of `names`, instead of those that the log
            gives.
        names: `PARAMETER_NAMES`, or `EXTENDED_NAMES` for viscous friction of its own in
            each direction.
        open_loop_alone: Whether the open loop is the only horizon.
        max_iterations: Largest number of steps along the gradient.

    Returns:
        The estimate.

    Raises:
        ValueError: If float64 is off, an argument is out of its range, the axis never
            moves, no start could be found, position and voltage are of opposite sense, or no
            parameters explain the motion.
    """
    _check(log, gain=gain, delay_samples=delay_samples)
    record = axis_record(log)
    force = gain * np.asarray(delayed(log.voltage, delay_samples))
    guesses = _starts(record, gain=gain) if starts is None else np.asarray(starts, dtype=float)
    ahead = horizons(record, force, open_loop_alone=open_loop_alone)
    guesses = np.pad(guesses, [(0, 0), (0, len(names) - guesses.shape[1])])
    velocities = np.tile(np.asarray(ahead.velocities), (len(guesses), 1))
    guesses = np.column_stack([np.log(guesses[:, 0]), guesses[:, 1:], velocities])
    lower = _lower(names, len(ahead.velocities))
    noise = max(record.noise, 1e-9 * record.motion)
    search = _Search(ahead, lower, noise, max_iterations)
    ends = search.minima(guesses, np.full(len(ahead.lengths), np.inf))
    reached = np.array([end.normal.cost for end in ends])
    best = ends[int(np.argmin(reached))].point
    # How much a start may shift is judged by what the horizons err by.
    square = search.square(best, np.full(len(ahead.lengths), np.inf))
    best = search.minima(best[None], square)[0].point
    square = search.square(best, square)
    weighted = Weighted(ahead, 1 / square, ahead.starts(best))
    polished = polish(weighted.linearised, weighted.costs, best, lower=lower)
    near = _AGREEING * ahead.count * len(ahead.lengths)
    found = _Found(
        names=names,
        horizons=ahead,
        square=square,
        polished=polished,
        force=float(np.sqrt(np.mean(force**2))),
        starts=len(guesses),
        agreeing_starts=int(np.sum(reached <= np.min(reached) + near)),
        iterations=max(end.iterations - 1 for end in ends) + polished.iterations,
    )
    return found.estimate(record, gain=gain)


@dataclasses.dataclass(frozen=True, eq=False)
class _Search:
    """The search along the gradient."""

    horizons: Horizons
    lower: Float[np.ndarray, " n"]
    noise: float
    max_iterations: int

    def minima(
        self, starts: Float[np.ndarray, "starts n"], square: Float[np.ndarray, " horizons"]
    ) -> list[Minimum[LogMeanSquares]]:
        """Where the starts lead, all of them at once.

        Where the residuals have kinks they come near a minimum and stall there: `polish` goes
        the rest of the way.
        """

        def together(points: list[Float[np.ndarray, " n"]]) -> list[LogMeanSquares]:
            both = self.horizons.linearised(np.stack(points), square)
            return [
                LogMeanSquares.of(*each, count=self.horizons.count, noise=self.noise)
                for each in zip(*both, strict=True)
            ]

        stopping = Stopping(
            evaluations=self.max_iterations + 1, decrement=_PROMISED, share=0.0, undamped=True
        )
        ends = minimise_together(
            together, list(starts), lower=self.lower, damping=_DAMPING, stopping=stopping
        )
        if not any(np.isfinite(end.normal.cost) for end in ends):
            raise ValueError(
                f"the residuals are finite at none of the {len(starts)} starts, expected a "
                f"finite simulation at one of them at least. Starts: {starts.tolist()}."
            )
        return ends

    def square(
        self, point: Float[np.ndarray, " n"], square: Float[np.ndarray, " horizons"]
    ) -> Float[np.ndarray, " horizons"]:
        """Mean squared error of each horizon at a point."""
        residuals, _ = self.horizons.linearised(point[None], square)
        return mean_squares(residuals[0], count=self.horizons.count, noise=self.noise)


@dataclasses.dataclass(frozen=True, eq=False)
class _Found:
    """The end of a search."""

    names: tuple[str, ...]
    horizons: Horizons
    square: Float[np.ndarray, " horizons"]
    polished: Polished
    force: float
    starts: int
    agreeing_starts: int
    iterations: int

    def estimate(self, record: AxisRecord, *, gain: float) -> DriveAxisEstimate:
        """The estimate that the search comes to."""
        size, theta = len(self.names), self.polished.parameters
        values = np.array([np.exp(theta[0]), *theta[1:size]])
        (residuals,), (jacobian,) = self.horizons.linearised(theta[None], self.square)
        # From here on the mass itself, not its logarithm; samples between pieces don't count.
        kept = np.asarray(self.horizons.kept)
        jacobian = jacobian[:, kept] / np.array([values[0], *np.ones(len(theta) - 1)])
        error = np.sqrt(np.mean(residuals[:, kept] ** 2, axis=1))
        _check_fit(record, float(error[0]), gain=gain)
        weight = 1 / np.maximum(error, record.noise)
        spread = errors(
            np.array([*values, *theta[size:]]),
            residuals[:, kept] * weight[:, None],
            jacobian * weight[:, None, None],
        )
        plausible = plausible_sizes(
            self.names,
            float(values[0]),
            force=self.force,
            speed=float(np.sqrt(np.mean(record.velocity[kept] ** 2))),
        )
        combined = told(
            self.names,
            values,
            one_way(self.names, jacobian[0], record.direction),
            plausible=plausible,
            noise=record.noise,
            motion=record.motion,
        )
        return self._judged(record, values, spread, combined, plausible, residuals[0])

    def _judged(
        self,
        record: AxisRecord,
        values: Float[np.ndarray, " n"],
        spread: Errors,
        combined: tuple[Combination, ...],
        plausible: Float[np.ndarray, " n"],
        residuals: Float[np.ndarray, " samples"],
    ) -> DriveAxisEstimate:
        size, noise = len(values), record.noise
        rmse = float(np.sqrt(np.sum(residuals**2) / self.horizons.count))
        failed = rmse > max(NOT_EXPLAINED * record.motion, 20 * noise)
        sigma = np.sqrt(np.diag(spread.covariance)[:size])
        untold = [any(not c.is_told and c.has(k) for c in combined) for k in range(size)]
        sigma = np.where(untold, np.inf, sigma)
        scale = np.maximum(np.abs(values), _NEGLIGIBLE * plausible)
        status = _status(self.names, values, sigma / scale, failed=failed)
        sigma = np.full(size, np.inf) if failed else sigma
        low = np.maximum(values - 1.96 * sigma, [0.0, *_lower(self.names)[1:]])
        period = float(np.median(np.diff(record.time)))
        return DriveAxisEstimate(
            parameters=AxisParameters(*values),
            sigma=AxisParameters(*sigma),
            interval95=jnp.asarray(np.stack([low, values + 1.96 * sigma], axis=1)),
            correlation=jnp.asarray(_correlation(spread.covariance[:size, :size])),
            status=status,
            open_loop_rmse=rmse,
            positions=record.position + residuals,
            memory=spread.bandwidth * period,
            starts=self.starts,
            agreeing_starts=self.agreeing_starts,
            iterations=self.iterations,
            converged=self.polished.converged,
            names=self.names,
            combinations=combined,
            changes=_changes(self.names, spread, scale),
            horizons=tuple(length * period for length in self.horizons.lengths[1:]),
            sum_sigma=sum_sigma(self.names, spread.covariance, combined),
            notes=record.notes,
            position_unit=record.log.position_unit,
        )


def _changes(
    names: tuple[str, ...], spread: Errors, scale: Float[np.ndarray, " n"]
) -> tuple[Change, ...]:
    """The parameters that the halves don't agree about, by more than is negligible."""
    first, second = (half.values for half in spread.halves)
    return tuple(
        Change(name, float(first[k]), float(second[k]))
        for k, name in enumerate(names)
        if spread.changes(k) > DISAGREEING
        and abs(float(second[k] - first[k])) > _WEAK * scale[k]
    )


def _check(log: AxisLog, *, gain: float, delay_samples: int) -> None:
    """Refuse what can't be fitted, saying why."""
    if log.position.dtype != jnp.float64:
        raise ValueError(
            f"the axis's log must be float64, got {log.position.dtype}: an open-loop fit "
            "accumulates rounding over the whole record. Call "
            '`jax.config.update("jax_enable_x64", True)` before reading the log.'
        )
    unit = "N m/V" if log.is_rotary else "N/V"
    if not (np.isfinite(gain) and gain != 0):
        raise ValueError(
            f"`gain` must be finite and not zero [{unit}], got {gain}. It is the drive's force "
            "per volt: the data alone give the parameters only in proportion to it."
        )
    if not 0 <= delay_samples < len(log.time):
        raise ValueError(
            f"`delay_samples` must be from 0 to {len(log.time) - 1} [samples], got "
            f"{delay_samples}. The voltage can't act before it is commanded."
        )
    if not float(jnp.ptp(log.position)) > 0:
        raise ValueError(
            f"the axis never moves: position is {float(log.position[0])} {log.position_unit} "
            "throughout, expected a record of motion in both directions. Log a run with "
            "more voltage."
        )


def _check_fit(record: AxisRecord, error: float, *, gain: float) -> None:
    """Refuse a fit that predicts no better than no motion at all."""
    if error < record.motion:
        return
    raise ValueError(
        f"no parameters explain the motion: the best open loop is off by {error:.3g} "
        f"{record.log.position_unit}, expected less than the motion itself, "
        f"{record.motion:.3g}. Check the gain's size, got {gain}, and that voltage and "
        "position belong together."
    )


def delayed(voltage: Float[Array, " samples"], samples: int) -> Float[Array, " samples"]:
    """Voltage that acts late; the first command is taken to have stood before.

    Args:
        voltage: Commands [V].
        samples: By how many samples.

    Returns:
        What acts [V].
    """
    kept = len(voltage) - samples
    return jnp.concatenate([jnp.broadcast_to(voltage[0], (samples,)), voltage[:kept]])


def _starts(record: AxisRecord, *, gain: float) -> Float[np.ndarray, "starts 4"]:
    """Inverse-dynamics fits, and the median one with its mass threefold and a third."""
    fits = [inverse_dynamics(record, gain=gain, half_window=half) for half in _HALF_WINDOWS]
    guesses = [fit for fit in fits if fit is not None]
    if opposes(record, gain=gain):
        raise ValueError(
            "the axis accelerates against its voltage: the encoder counts the other way, or "
            f"the gain's sign is wrong, got {gain}, expected {-gain:g} if so. Give the gain "
            "with the other sign, or turn the encoder's sign round."
        )
    if not guesses:
        raise ValueError(
            f"no start found: with a gain of {gain} no positive mass balances the "
            "voltage, expected acceleration along the force. Check the gain's sign, and "
            "that the record has accelerations well above the position's resolution."
        )
    check_mass(guesses, record, gain=gain)
    # Twice as heavy or as light: should smoothing have biased all of them the same way.
    middle = np.median(guesses, axis=0)
    spread = [middle * np.array([factor, 1.0, 1.0, 1.0]) for factor in (0.5, 2.0)]
    return np.array(guesses + spread)


def _lower(names: tuple[str, ...], velocities: int = 0) -> Float[np.ndarray, " n"]:
    """Lower bounds of what the search varies."""
    law = [0.0 if name in ("viscous", "coulomb") else -np.inf for name in names]
    return np.array([*law, *[-np.inf] * velocities])


def _correlation(covariance: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "n n"]:
    """Correlation matrix; a parameter without any variance is correlated with none."""
    sigma = np.sqrt(np.diag(covariance))
    product = np.outer(sigma, sigma)
    ratio = np.divide(covariance, product, out=np.zeros_like(covariance), where=product > 0)
    np.fill_diagonal(ratio, 1.0)
    return ratio


def _status(
    names: tuple[str, ...],
    values: Float[np.ndarray, " n"],
    relative: Float[np.ndarray, " n"],
    *,
    failed: bool,
) -> tuple[str, ...]:
    """How far each parameter is known, by its standard error over its size."""

    def status(value: float, error: float, bounded: bool) -> str:
        if failed:
            return DOES_NOT_FIT
        if bounded and value <= 0:
            return "at_bound"
        if not np.isfinite(error):
            return "unidentifiable"
        return "weak" if error > _WEAK else "identified"

    bounded = np.isfinite(_lower(names)).tolist()
    rows = zip(values.tolist(), relative.tolist(), bounded, strict=True)
    return tuple(status(*row) for row in rows)
