"""Inertia, friction and offset of one motor-driven axis, from its open-loop response."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from identification.axis.inverse_dynamics import inverse_dynamics
from identification.axis.log import AxisLog
from identification.axis.motion import AxisParameters, axis_positions
from identification.axis.pattern_search import Evaluate, Polished, polish
from scdpr_jax.numerics.levenberg_marquardt import Damping, Minimum, Stopping, minimise_together
from scdpr_jax.numerics.long_run_variance import sandwich
from scdpr_jax.numerics.merit import SumOfSquares
from scdpr_jax.robot.fields import real, si

PARAMETER_NAMES = ("mass", "viscous", "coulomb", "offset")
"""The usual law's parameters, in the order of every vector and matrix here."""

EXTENDED_NAMES = (*PARAMETER_NAMES, "viscous_difference")
"""Those of the law in which viscous friction differs with the direction."""

_HALF_WINDOWS = (3, 10, 30, 100)  # samples: noise decides which is best, so all are starts
_BATCH = 8  # simulations at once: as many directions as `polish` tries, so one compilation
_AGREEING = 1.1  # of the best sum of squares: 5 % of the error, before the polish
_DAMPING = Damping(rise=2.0, growth=2.0, least=0.0, most=1e8)
"""Nielsen's: a kink is crossed by a step only a little shorter, or by none."""
_PROMISED = 1e-10
"""Share of the misfit that a step has to promise [1]: no parameter moves by 1e-4 of its
white-noise standard error in a record of less than 1e6 samples."""
_WEAK, _UNIDENTIFIABLE = 0.1, 0.5  # standard error over value, or over force for the offset


class DriveAxisEstimate(eqx.Module):
    """Parameters of an axis with their uncertainty, and how well they predict its log."""

    parameters: AxisParameters
    """Values [kg, N s/m, N, N]."""
    sigma: AxisParameters
    """Standard errors, robust to correlated residuals [kg, N s/m, N, N]."""
    interval95: Float[Array, "parameters 2"]
    """95 % intervals, one row for each of `names`."""
    correlation: Float[Array, "parameters parameters"]
    """Correlation of the estimates [1]."""
    status: tuple[str, ...] = eqx.field(static=True)
    """`identified`, `weak`, `unidentifiable` or `at_bound`, one for each parameter."""
    open_loop_rmse: Float[Array, ""] = eqx.field(converter=real, metadata=si("m"))
    """Root mean square of simulated minus measured position [m]."""
    positions: Float[Array, " samples"] = eqx.field(converter=real, metadata=si("m"))
    """Simulated positions, the whole record from its first sample at rest [m]."""
    memory: Float[Array, ""] = eqx.field(converter=real, metadata=si("s"))
    """Time over which the residuals were taken to hang together [s]."""
    starts: int = eqx.field(static=True)
    """Starts of the search."""
    agreeing_starts: int = eqx.field(static=True)
    """Starts that came within 5 % of the best error, before the polish."""
    iterations: int = eqx.field(static=True)
    """Steps of the search, those along the gradient and those of the polish."""
    converged: bool = eqx.field(static=True)
    """Whether no step in any direction was left that lowers the error noticeably."""
    names: tuple[str, ...] = eqx.field(static=True, default=PARAMETER_NAMES)
    """What was estimated: `PARAMETER_NAMES` or `EXTENDED_NAMES`."""


def estimate_drive_axis(
    log: AxisLog,
    *,
    gain: float,
    delay_samples: int = 0,
    starts: Float[np.ndarray, "starts parameters"] | None = None,
    names: tuple[str, ...] = PARAMETER_NAMES,
    max_iterations: int = 12,
) -> DriveAxisEstimate:
    r"""Fit $M \ddot q + F_v \dot q + F_c\,\mathrm{Sgn}\,\dot q + o \ni g u$ by output error.

    The axis is simulated from the voltage over the whole record, started at the first
    sample at rest and never put right; the parameters minimise the distance from the
    measured positions. That asks more than a balance of forces does (in closed loop the
    position hardly depends on the parameters), and it gives what predicts best.

    The search starts from inverse-dynamics fits at several smoothings, so it needs no
    tuning, and goes by exact gradients (Levenberg–Marquardt). The error has kinks where
    the axis only just stops or doesn't, and its minimum is likely to lie on one: the best
    start is polished by a search that needs no gradient.

    Standard errors are robust to correlated residuals, see
    `scdpr_jax.numerics.long_run_variance.sandwich`: what four parameters leave over is
    mostly the axis's own departure from the model, not noise.

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
        max_iterations: Largest number of steps along the gradient.

    Returns:
        The estimate.

    Raises:
        ValueError: If float64 is off, an argument is out of its range, the axis never
            moves, no start could be found, or no parameters explain the motion.
    """
    _check(log, gain=gain, delay_samples=delay_samples)
    force = gain * delayed(log.voltage, delay_samples)[:-1]
    loop = _OpenLoop(force, jnp.diff(log.time), log.position)
    guesses = _starts(log, gain=gain) if starts is None else np.asarray(starts, dtype=float)
    guesses = np.pad(guesses, [(0, 0), (0, len(names) - guesses.shape[1])])
    lower = _lower(names)
    guesses = np.column_stack([np.log(guesses[:, 0]), guesses[:, 1:]])
    ends = _minima(loop.linearised, guesses, lower=lower, max_iterations=max_iterations)
    reached = np.array([end.normal.cost for end in ends])
    polished = polish(
        loop.linearised, loop.costs, ends[int(np.argmin(reached))].point, lower=lower
    )
    _check_fit(log, polished, gain=gain)
    return _estimate(
        log,
        polished,
        names=names,
        force=np.asarray(force),
        starts=len(guesses),
        agreeing_starts=int(np.sum(reached <= _AGREEING * np.min(reached))),
        iterations=max(end.iterations - 1 for end in ends) + polished.iterations,
    )


def _minima(
    evaluate: Evaluate,
    starts: Float[np.ndarray, "starts n"],
    *,
    lower: Float[np.ndarray, " n"],
    max_iterations: int,
) -> list[Minimum[SumOfSquares]]:
    """Where the starts lead along the gradient, all of them at once.

    Where the residuals have kinks they come near a minimum and stall there: `polish` goes the
    rest of the way.
    """

    def together(points: list[Float[np.ndarray, " n"]]) -> list[SumOfSquares]:
        return list(map(SumOfSquares, *evaluate(np.stack(points))))

    stopping = Stopping(evaluations=max_iterations + 1, share=_PROMISED, undamped=True)
    ends = minimise_together(
        together, list(starts), lower=lower, damping=_DAMPING, stopping=stopping
    )
    if not any(np.isfinite(end.normal.cost) for end in ends):
        raise ValueError(
            f"the residuals are finite at none of the {len(starts)} starts, expected a finite "
            f"simulation at one of them at least. Starts: {starts.tolist()}."
        )
    return ends


def _check(log: AxisLog, *, gain: float, delay_samples: int) -> None:
    """Refuse what can't be fitted, saying why."""
    if log.position.dtype != jnp.float64:
        raise ValueError(
            f"the axis's log must be float64, got {log.position.dtype}: an open-loop fit "
            "accumulates rounding over the whole record. Call "
            '`jax.config.update("jax_enable_x64", True)` before reading the log.'
        )
    if not (np.isfinite(gain) and gain != 0):
        raise ValueError(
            f"`gain` must be finite and not zero [N/V], got {gain}. It is the drive's force "
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


def _check_fit(log: AxisLog, polished: Polished, *, gain: float) -> None:
    """Refuse a fit that predicts no better than no motion at all."""
    error = float(np.sqrt(np.mean(polished.residuals**2)))
    motion = float(np.std(log.position))
    if error >= motion:
        raise ValueError(
            f"no parameters explain the motion: the best open loop is off by {error:.3g} "
            f"{log.position_unit}, expected less than the motion itself, {motion:.3g}. Check "
            f"the gain's sign and size, got {gain}, that the log starts at rest, and that "
            "voltage and position belong together."
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


def _starts(log: AxisLog, *, gain: float) -> Float[np.ndarray, "starts 4"]:
    """Inverse-dynamics fits, and the median one with its mass threefold and a third."""
    fits = [inverse_dynamics(log, gain=gain, half_window=half) for half in _HALF_WINDOWS]
    guesses = [fit for fit in fits if fit is not None]
    if not guesses:
        raise ValueError(
            f"no start found: with a gain of {gain} N/V no positive mass balances the "
            "voltage, expected acceleration along the force. Check the gain's sign, and "
            "that the record has accelerations well above the position's resolution."
        )
    # Twice as heavy or as light: should smoothing have biased all of them the same way.
    middle = np.median(guesses, axis=0)
    spread = [middle * np.array([factor, 1.0, 1.0, 1.0]) for factor in (0.5, 2.0)]
    return np.array(guesses + spread)


def _lower(names: tuple[str, ...]) -> Float[np.ndarray, " parameters"]:
    """Lower bounds of what the search varies."""
    return np.array([0.0 if name in ("viscous", "coulomb") else -np.inf for name in names])


def _from_vector(theta: Float[Array, " parameters"]) -> AxisParameters:
    """Parameters from what the search varies: the mass's logarithm and the rest as it is."""
    return AxisParameters(jnp.exp(theta[0]), *theta[1:])


def _filled(thetas: Float[np.ndarray, "points n"]) -> Float[Array, "batch n"]:
    """The points with their last repeated up to the size of a batch, or a multiple of it."""
    missing = -len(thetas) % _BATCH
    return jnp.asarray(np.concatenate([thetas, np.repeat(thetas[-1:], missing, axis=0)]))


class _OpenLoop(eqx.Module):
    """A record that is simulated from its first sample on, for any number of parameters."""

    force: Float[Array, " steps"]
    steps: Float[Array, " steps"]
    position: Float[Array, " samples"]

    def residuals(self, theta: Float[Array, " n"]) -> Float[Array, " samples"]:
        """Simulated minus measured positions [m]."""
        axis, start = _from_vector(theta), self.position[0]
        return axis_positions(axis, self.force, steps=self.steps, start=start) - self.position

    def linearised(
        self, thetas: Float[np.ndarray, "points n"]
    ) -> tuple[Float[np.ndarray, "points samples"], Float[np.ndarray, "points samples n"]]:
        """Residuals and their derivatives at some points."""
        both = _linearised(self, _filled(thetas))
        residuals, jacobian = (np.asarray(part)[: len(thetas)] for part in both)
        return residuals, jacobian

    def costs(self, thetas: Float[np.ndarray, "points n"]) -> Float[np.ndarray, " points"]:
        """Half the sums of squared residuals at some points [m²]."""
        return np.asarray(_costs(self, _filled(thetas)))[: len(thetas)]


@jax.jit
def _linearised(
    loop: _OpenLoop, thetas: Float[Array, "batch n"]
) -> tuple[Float[Array, "batch samples"], Float[Array, "batch samples n"]]:
    def residuals(theta: Float[Array, " n"]) -> tuple[Array, Array]:
        values = loop.residuals(theta)
        return values, values

    jacobian, values = jax.vmap(jax.jacfwd(residuals, has_aux=True))(thetas)
    return values, jacobian


@jax.jit
def _costs(loop: _OpenLoop, thetas: Float[Array, "batch n"]) -> Float[Array, " batch"]:
    return 0.5 * jnp.sum(jnp.square(jax.vmap(loop.residuals)(thetas)), axis=1)


def _estimate(
    log: AxisLog,
    polished: Polished,
    *,
    names: tuple[str, ...],
    force: Float[np.ndarray, " steps"],
    starts: int,
    agreeing_starts: int,
    iterations: int,
) -> DriveAxisEstimate:
    """The estimate of a finished search."""
    theta = polished.parameters
    values = np.array([np.exp(theta[0]), *theta[1:]])
    # From here on the mass itself, not its logarithm.
    spread = sandwich(
        polished.jacobian / np.array([values[0], *np.ones(len(values) - 1)]),
        polished.residuals,
    )
    sigma = np.sqrt(np.diag(spread.covariance))
    low = np.maximum(values - 1.96 * sigma, np.array([0.0, *_lower(names)[1:]]))
    return DriveAxisEstimate(
        parameters=AxisParameters(*values),
        sigma=AxisParameters(*sigma),
        interval95=jnp.asarray(np.stack([low, values + 1.96 * sigma], axis=1)),
        correlation=jnp.asarray(_correlation(spread.covariance)),
        status=_status(names, values, sigma, force=float(np.sqrt(np.mean(force**2)))),
        open_loop_rmse=np.sqrt(np.mean(polished.residuals**2)),
        positions=np.asarray(log.position) + polished.residuals,
        memory=spread.bandwidth * np.median(np.diff(np.asarray(log.time))),
        starts=starts,
        agreeing_starts=agreeing_starts,
        iterations=iterations,
        converged=polished.converged,
        names=names,
    )


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
    sigma: Float[np.ndarray, " n"],
    *,
    force: float,
) -> tuple[str, ...]:
    """How far each parameter is known.

    The offset is measured by the force [N] it opposes, the difference of the viscous
    frictions by their mean.
    """
    scales = np.abs(values)
    scales[3] = max(scales[3], force)
    scales[4:] = np.maximum(scales[4:], values[1])

    def status(value: float, error: float, scale: float, bounded: bool) -> str:
        if bounded and value <= 0:
            return "at_bound"
        if error > _UNIDENTIFIABLE * scale:
            return "unidentifiable"
        return "weak" if error > _WEAK * scale else "identified"

    bounded = np.isfinite(_lower(names))
    rows = zip(values, sigma, scales, bounded.tolist(), strict=True)
    return tuple(status(float(v), float(e), float(s), b) for v, e, s, b in rows)
