r"""How far ahead an axis is predicted: from a few samples to the whole record, open loop.

Open loop over the whole record asks for what predicts best in the long run, and what the law
lacks drifts: friction that changes from minute to minute is then explained by mass. Predictions
over a few samples hardly see that, and tell the mass; but they hardly see an offset. Neither is
the right one. So there are several, each four times as long as the one before, and what is
minimised is

$$ \sum_h \ln\Big(\sigma^2 + \frac1n \sum_t r_{h,t}^2\Big), $$

the likelihood of errors whose size each horizon knows by itself: one that is explained well
counts for more, and none outvotes the others by being long. With noise alone the open loop
decides, as it should. Weights by hand would be simpler and true of one axis only.

Where a prediction begins, position and velocity are measured, and not exactly. What a shift of
either explains is taken off the residuals and off their derivatives, as far as the noise lets
one expect a shift (generalised least squares with random starts). Taking the measured velocity
for the true one would be simpler, and its smoothing rounds off just the corners that friction
makes; leaving it free throws away what a fine encoder tells.

References: the horizons as prediction errors, L. Ljung, "System Identification", 2nd ed., 1999,
section 7.2; simulation restarted on the way, H. G. Bock, "Recent advances in parameter
identification techniques for O.D.E.", 1983.
"""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Float64, Int

from identification.axis.motion import AxisParameters, Restarts, restarted_positions
from identification.axis.record import AxisRecord
from scdpr_jax.numerics.merit import Merit

FIRST = 25
"""Samples of the shortest prediction: its acceleration stands clear of the noise."""

LONGER = 4
"""Times by which each prediction is longer than the one before [1]."""

FEWEST = 16
"""Predictions of the longest kind that a record holds at least; beside the open loop."""

_TINY = 1e-12  # m and m/s: noise of a log without any
_BATCH = 8  # simulations at once: as many directions as `polish` tries, so one compilation


@dataclasses.dataclass(frozen=True, eq=False)
class LogMeanSquares(Merit):
    """The sum over the horizons of a log of their mean squared errors, at a point."""

    cost: float
    gradient: Float[np.ndarray, " n"]
    matrix: Float[np.ndarray, "n n"]

    @classmethod
    def of(
        cls,
        residuals: Float[np.ndarray, "horizons samples"],
        jacobian: Float[np.ndarray, "horizons samples n"],
        *,
        count: int,
        noise: float,
    ) -> "LogMeanSquares":
        """The merit of some residuals.

        Args:
            residuals: Residuals of each horizon.
            jacobian: Their derivatives.
            count: Samples that have residuals.
            noise: Standard deviation of the positions' noise.

        Returns:
            The merit, infinite where a residual or a derivative isn't finite.
        """
        size = jacobian.shape[-1]
        if not (np.all(np.isfinite(residuals)) and np.all(np.isfinite(jacobian))):
            return cls(np.inf, np.zeros(size), np.zeros((size, size)))
        square = mean_squares(residuals, count=count, noise=noise)
        gradient = np.einsum("ht,htn->hn", residuals, jacobian) / square[:, None]
        matrix = np.einsum("htn,htm->hnm", jacobian, jacobian) / square[:, None, None]
        cost = count * float(np.sum(np.log(square)))
        return cls(cost, gradient.sum(axis=0), matrix.sum(axis=0))


def mean_squares(
    residuals: Float[np.ndarray, "horizons samples"], *, count: int, noise: float
) -> Float[np.ndarray, " horizons"]:
    """Mean squared error of each horizon, and the noise's variance.

    Args:
        residuals: Residuals of each horizon.
        count: Samples that have residuals.
        noise: Standard deviation of the positions' noise.

    Returns:
        Their sums.
    """
    return np.sum(residuals**2, axis=-1) / count + noise**2


class Horizons(eqx.Module):
    """A record that is simulated over several horizons at once, for any parameters."""

    force: Float[Array, " steps"]
    """Force of the drive over each step [N or N m]."""
    steps: Float[Array, " steps"]
    """Durations of the steps [s]."""
    restarts: Restarts
    """Where each horizon's simulations begin; the first one's where pieces do."""
    position: Float[Array, " samples"]
    """Measured positions [m or rad]."""
    kept: Bool[Array, " samples"]
    """Samples of the pieces."""
    unknown: Int[Array, " samples"]
    """Number of the start velocity that a sample's piece begins with; -1 where it rests."""
    velocities: Float[Array, " moving"]
    """First guesses of the start velocities that are estimated [m/s or rad/s]."""
    start_noise: Float[Array, "2"]
    """Standard deviations of the position [m or rad] and the velocity [m/s or rad/s] that a
    prediction begins with."""
    lengths: tuple[int, ...] = eqx.field(static=True)
    """Samples of each horizon's predictions; 0 for the open loop."""

    @property
    def count(self) -> int:
        """Samples that have residuals."""
        return int(np.sum(np.asarray(self.kept)))

    def residuals(
        self, theta: Float[Array, " n"], shift: Float[Array, ""]
    ) -> Float[Array, "horizons samples"]:
        """Simulated minus measured positions.

        Args:
            theta: What a search varies, see `parameters_of`; the start velocities last.
            shift: Added to all velocities that a prediction begins with, but those of pieces
                that begin at rest [m/s or rad/s].

        Returns:
            Residuals of each horizon [m or rad]; 0 outside of the pieces.
        """
        law = theta[: len(theta) - len(self.velocities)]
        begins = self.restarts.here[0]
        estimated = jnp.zeros_like(self.position)
        if len(self.velocities):
            estimated = jnp.where(self.unknown >= 0, theta[len(law) :][self.unknown], 0.0)

        def residual(restarts: Restarts) -> Float[Array, " samples"]:
            started = jnp.where(self.unknown >= 0, estimated + shift, restarts.velocity)
            velocity = jnp.where(begins, started, restarts.velocity + shift)
            simulated = restarted_positions(
                parameters_of(law),
                self.force,
                steps=self.steps,
                restarts=Restarts(restarts.here, restarts.position, velocity),
            )
            return jnp.where(self.kept, simulated - self.position, 0.0)

        return jax.vmap(residual)(self.restarts)

    def linearised(
        self, thetas: Float[np.ndarray, "points n"], square: Float[np.ndarray, " horizons"]
    ) -> tuple[
        Float[np.ndarray, "points horizons samples"],
        Float[np.ndarray, "points horizons samples n"],
    ]:
        """Residuals and their derivatives at some points, without what the starts explain.

        Args:
            thetas: What a search varies.
            square: Mean squared error of each horizon, about [m² or rad²].

        Returns:
            Both.
        """
        residuals, slopes = self._raw(thetas)
        count = len(self.velocities)
        # A piece depends on its own start velocity alone, so one derivative serves them all.
        own = np.asarray(self.unknown)[:, None] == np.arange(count)
        columns = np.concatenate(
            [residuals[..., None], slopes[..., :-1], slopes[..., -1:] * own], axis=-1
        )
        for k, starts in enumerate(slopes[..., -1]):
            columns[k] = self.without_starts(columns[k], starts, square)
        return columns[..., 0], columns[..., 1:]

    def starts(self, theta: Float[np.ndarray, " n"]) -> Float[np.ndarray, "horizons samples"]:
        """Derivatives of the residuals with respect to the velocity that predictions begin at.

        Args:
            theta: What a search varies.

        Returns:
            The derivatives [s].
        """
        return self._raw(theta[None])[1][0, ..., -1]

    def squares(
        self,
        thetas: Float[np.ndarray, "points n"],
        starts: Float[np.ndarray, "horizons samples"],
        square: Float[np.ndarray, " horizons"],
    ) -> Float[np.ndarray, "points horizons"]:
        """Sums of squared residuals of each horizon, without what the starts explain.

        Args:
            thetas: What a search varies.
            starts: Derivatives with respect to the starts, at some point nearby.
            square: Mean squared error of each horizon, about [m² or rad²].

        Returns:
            The sums [m² or rad²].
        """
        residuals = np.asarray(_residuals(self, _filled(thetas)))[: len(thetas)]
        left = [
            self.without_starts(each[..., None], starts, square)[..., 0] for each in residuals
        ]
        return np.sum(np.square(left), axis=-1)

    def without_starts(
        self,
        columns: Float[np.ndarray, "horizons samples k"],
        starts: Float[np.ndarray, "horizons samples"],
        square: Float[np.ndarray, " horizons"],
    ) -> Float[np.ndarray, "horizons samples k"]:
        r"""Columns without what shifts of the predictions' starts explain.

        With the derivatives $B$ of a prediction by its start's position and velocity it is
        $c - B (B^T B + \sigma^2 S^{-1})^{-1} B^T c$, $S$ the variances of the starts.

        Args:
            columns: Residuals or derivatives.
            starts: Derivatives with respect to the starts' velocity.
            square: Mean squared error $\sigma^2$ of each horizon [m² or rad²].

        Returns:
            The columns; those of the open loop as they are.
        """
        kept = np.asarray(self.kept)[:, None]
        left = columns.copy()
        for k in range(1, len(self.lengths)):
            here = np.asarray(self.restarts.here[k])
            edges, number = np.flatnonzero(here), np.cumsum(here) - 1
            basis = np.column_stack([kept.astype(float), starts[k][:, None] * kept])
            products = basis[:, :, None] * np.concatenate([basis, columns[k]], axis=1)[:, None]
            sums = np.add.reduceat(products, edges)
            stiff = square[k] / np.square(np.maximum(np.asarray(self.start_noise), _TINY))
            shift = np.linalg.solve(sums[:, :, :2] + np.diag(stiff), sums[:, :, 2:])
            left[k] = columns[k] - np.einsum("sb,sbk->sk", basis, shift[number])
        return left

    def _raw(
        self, thetas: Float[np.ndarray, "points n"]
    ) -> tuple[
        Float[np.ndarray, "points horizons samples"],
        Float[np.ndarray, "points horizons samples k"],
    ]:
        """Residuals, and their derivatives by the law and by the velocity of all starts."""
        both = _linearised(self, _filled(thetas))
        residuals, slopes = (np.asarray(part)[: len(thetas)] for part in both)
        return residuals, slopes


def horizons(
    record: AxisRecord, force: Float[np.ndarray, " samples"], *, open_loop_alone: bool = False
) -> Horizons:
    """The horizons that a record is long enough for.

    Args:
        record: The record.
        force: Force of the drive from each sample on [N or N m].
        open_loop_alone: Whether the open loop is the only one.

    Returns:
        The horizons, the open loop first.
    """
    longest = max(map(len, record.pieces))
    lengths = [0]
    while not open_loop_alone and FEWEST * FIRST * LONGER ** (len(lengths) - 1) <= longest:
        lengths.append(FIRST * LONGER ** (len(lengths) - 1))
    here = np.stack([_begins(record, length) for length in lengths])
    moving = [k for k, piece in enumerate(record.pieces) if piece.moves]
    starts = [piece.start for piece in record.pieces]
    velocity = record.velocity.copy()
    # A piece that doesn't move begins at rest: exactly, or friction could never hold it.
    velocity[starts] = 0.0
    numbers = np.array([moving.index(k) if k in moving else -1 for k in range(len(starts))])
    every = (len(lengths), 1)
    return Horizons(
        force=jnp.asarray(force[:-1]),
        steps=jnp.asarray(np.diff(record.time)),
        restarts=Restarts(
            jnp.asarray(here),
            jnp.asarray(np.tile(record.position, every)),
            jnp.asarray(np.tile(velocity, every)),
        ),
        position=jnp.asarray(record.position),
        kept=jnp.asarray(record.piece_of >= 0),
        unknown=jnp.asarray(np.where(record.piece_of >= 0, numbers[record.piece_of], -1)),
        velocities=jnp.asarray([float(record.velocity[starts[k]]) for k in moving]),
        start_noise=jnp.asarray([record.noise, record.velocity_noise]),
        lengths=tuple(lengths),
    )


def _begins(record: AxisRecord, length: int) -> Bool[np.ndarray, " samples"]:
    """Samples at which a horizon's simulations begin."""
    here = np.zeros(len(record.time), dtype=bool)
    here[0] = True
    for piece in record.pieces:
        here[piece.start] = True
        if length:
            # The last prediction of a piece is up to half as long again, or half as long.
            here[piece.start : max(piece.end - length // 2, piece.start + 1) : length] = True
    return here


def parameters_of(theta: Float[Array, " n"] | Float64[np.ndarray, " n"]) -> AxisParameters:
    """Parameters from what a search varies: the mass's logarithm and the rest as it is.

    Args:
        theta: The mass's logarithm, then the law's other parameters.

    Returns:
        The parameters.
    """
    return AxisParameters(jnp.exp(theta[0]), *theta[1:])


@dataclasses.dataclass(frozen=True, eq=False)
class Weighted:
    """The horizons as one vector of residuals, each over its own root mean square."""

    horizons: Horizons
    """The horizons."""
    weights: Float[np.ndarray, " horizons"]
    """One over each horizon's mean squared error [1/m² or 1/rad²]."""
    starts: Float[np.ndarray, "horizons samples"]
    """Derivatives with respect to the starts' velocity [s]."""

    def linearised(
        self, thetas: Float[np.ndarray, "points n"]
    ) -> tuple[Float[np.ndarray, "points m"], Float[np.ndarray, "points m n"]]:
        """Weighted residuals and their derivatives at some points.

        Args:
            thetas: What a search varies.

        Returns:
            Both, over all horizons.
        """
        residuals, jacobian = self.horizons.linearised(thetas, 1 / self.weights)
        root = np.sqrt(self.weights)[:, None]
        flat = (residuals * root).reshape(len(thetas), -1)
        return flat, (jacobian * root[..., None]).reshape(*flat.shape, -1)

    def costs(self, thetas: Float[np.ndarray, "points n"]) -> Float[np.ndarray, " points"]:
        """Half the sums of squared weighted residuals at some points.

        Args:
            thetas: What a search varies.

        Returns:
            The costs [1].
        """
        return 0.5 * self.horizons.squares(thetas, self.starts, 1 / self.weights) @ self.weights


def _filled(thetas: Float[np.ndarray, "points n"]) -> Float[Array, "batch n"]:
    """The points with their last repeated up to the size of a batch, or a multiple of it."""
    missing = -len(thetas) % _BATCH
    return jnp.asarray(np.concatenate([thetas, np.repeat(thetas[-1:], missing, axis=0)]))


@jax.jit
def _linearised(horizons: Horizons, thetas: Float[Array, "batch n"]) -> tuple[Array, Array]:
    size = thetas.shape[1] - len(horizons.velocities)

    def residuals(varied: Float[Array, " n"], theta: Float[Array, " m"]) -> tuple[Array, Array]:
        whole = jnp.concatenate([varied[:-1], theta[size:]])
        values = horizons.residuals(whole, varied[-1])
        return values, values

    def both(theta: Float[Array, " m"]) -> tuple[Array, Array]:
        varied = jnp.append(theta[:size], 0.0)
        jacobian, values = jax.jacfwd(residuals, has_aux=True)(varied, theta)
        return values, jacobian

    return jax.vmap(both)(thetas)


@jax.jit
def _residuals(horizons: Horizons, thetas: Float[Array, "batch n"]) -> Array:
    return jax.vmap(lambda theta: horizons.residuals(theta, jnp.zeros(())))(thetas)
