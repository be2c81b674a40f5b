r"""Decaying sines fitted to an unevenly sampled signal by variable projection.

$$ x(t) = \sum_i e^{-\sigma_i t} (c_i \cos \omega_i t + s_i \sin \omega_i t) + o
          \;[\, + d\, t\,] $$

For given $\omega_i, \sigma_i$ the rest is linear, so a grid over one mode's frequency and
decay finds the start, and nothing has to be guessed.
"""

import dataclasses

import numpy as np
import scipy.optimize
from jaxtyping import Float

_GRID = 0.25  # of the reciprocal length: a quarter of the main lobe's half-width
_DECAYS = (0.0, 1.0, 4.0)  # of the reciprocal length: from none to all within the record
_APART = 0.5  # of the reciprocal length: closer modes are one


@dataclasses.dataclass(frozen=True, eq=False)
class Decay:
    """A fitted sum of decaying sines."""

    angular_frequency: Float[np.ndarray, " modes"]
    r"""Damped angular frequencies $\omega_i$ [rad/s]."""
    rate: Float[np.ndarray, " modes"]
    r"""Decay rates $\sigma_i$ [1/s]."""
    amplitude: Float[np.ndarray, " modes"]
    """Amplitudes at time 0 [in the signal's unit]."""
    residuals: Float[np.ndarray, " samples"]
    """Fit minus signal."""
    jacobian: Float[np.ndarray, "samples parameters"]
    """Derivatives by all frequencies, then all rates, then the linear coefficients."""


def fit_decay(
    time: Float[np.ndarray, " samples"],
    signal: Float[np.ndarray, " samples"],
    *,
    band: tuple[float, float],
    drift: bool,
    beside: Decay | None = None,
) -> Decay:
    """Fit one decaying sine, or one more beside those of an earlier fit.

    Args:
        time: Time of each sample [s], from 0.
        signal: The signal, without lost samples.
        band: Lowest and highest frequency to look at [Hz].
        drift: Whether a linear drift is fitted besides the offset.
        beside: Fit whose modes are kept as starts, None for none.

    Returns:
        The fit, all modes refined together.
    """
    frequency, rate = _best_start(time, signal, band=band, drift=drift, beside=beside)
    modes = len(frequency)
    basis = _basis(time, frequency, rate, drift=drift)
    linear, *_ = np.linalg.lstsq(basis, signal, rcond=None)

    def residuals(p: Float[np.ndarray, " parameters"]) -> Float[np.ndarray, " samples"]:
        columns = _basis(time, p[:modes], p[modes : 2 * modes], drift=drift)
        return columns @ p[2 * modes :] - signal

    def jacobian(p: Float[np.ndarray, " parameters"]) -> Float[np.ndarray, "samples _"]:
        c, s = p[2 * modes : 4 * modes].reshape(modes, 2).T
        basis = _basis(time, p[:modes], p[modes : 2 * modes], drift=drift)
        cosines, sines = basis[:, 0 : 2 * modes : 2], basis[:, 1 : 2 * modes : 2]
        by_frequency = time[:, None] * (s * cosines - c * sines)
        by_rate = -time[:, None] * (c * cosines + s * sines)
        return np.concatenate([by_frequency, by_rate, basis], axis=1)

    start = np.concatenate([frequency, rate, linear])
    fit = scipy.optimize.least_squares(
        residuals, start, jac=jacobian, x_scale="jac", method="lm"
    )
    pairs = fit.x[2 * modes : 4 * modes].reshape(modes, 2)
    return Decay(
        angular_frequency=fit.x[:modes],
        rate=fit.x[modes : 2 * modes],
        amplitude=np.hypot(pairs[:, 0], pairs[:, 1]),
        residuals=fit.fun,
        jacobian=jacobian(fit.x),
    )


def _best_start(
    time: Float[np.ndarray, " samples"],
    signal: Float[np.ndarray, " samples"],
    *,
    band: tuple[float, float],
    drift: bool,
    beside: Decay | None,
) -> tuple[Float[np.ndarray, " modes"], Float[np.ndarray, " modes"]]:
    """Frequencies [rad/s] and rates [1/s] with the best further mode of the grid."""
    duration = time[-1]
    frequencies = np.zeros(0) if beside is None else beside.angular_frequency
    rates = np.zeros(0) if beside is None else beside.rate
    others = _basis(time, frequencies, rates, drift=drift)
    # What is orthogonal to the earlier modes: the grid then asks for two columns alone.
    q, _ = np.linalg.qr(others)
    rest = signal - q @ (q.T @ signal)
    grid = 2 * np.pi * np.arange(band[0], band[1], _GRID / duration)
    near = np.abs(grid[:, None] - frequencies) < 2 * np.pi * _APART / duration
    grid = grid[~np.any(near, axis=1)]
    omega, sigma = (
        axis.ravel() for axis in np.meshgrid(grid, np.array(_DECAYS) / duration, indexing="ij")
    )
    wave = np.exp((1j * omega - sigma)[:, None] * time)
    cosine, sine = (part - (part @ q) @ q.T for part in (wave.real, wave.imag))
    best = int(np.argmax(_explained(cosine, sine, rest)))
    return np.append(frequencies, omega[best]), np.append(rates, sigma[best])


def _explained(
    cosine: Float[np.ndarray, "candidates samples"],
    sine: Float[np.ndarray, "candidates samples"],
    signal: Float[np.ndarray, " samples"],
) -> Float[np.ndarray, " candidates"]:
    """Sum of squares of a signal that each pair of columns explains."""
    cc, ss, cs = np.sum(cosine**2, 1), np.sum(sine**2, 1), np.sum(cosine * sine, 1)
    c, s = cosine @ signal, sine @ signal
    determinant = cc * ss - cs**2
    # A pair that is next to parallel explains nothing that one of its columns doesn't.
    sound = determinant > 1e-6 * cc * ss
    gain = ss * c**2 - 2 * cs * c * s + cc * s**2
    return np.divide(gain, determinant, out=np.zeros_like(gain), where=sound)


def _basis(
    time: Float[np.ndarray, " samples"],
    frequency: Float[np.ndarray, " modes"],
    rate: Float[np.ndarray, " modes"],
    *,
    drift: bool,
) -> Float[np.ndarray, "samples columns"]:
    """Columns: cosine and sine of each mode, offset, and drift if asked for."""
    columns = []
    for omega, sigma in zip(frequency, rate, strict=True):
        # A rate this negative is on its way out of the search: keep its column finite.
        envelope = np.exp(np.minimum(-sigma * time, 50.0))
        columns += [envelope * np.cos(omega * time), envelope * np.sin(omega * time)]
    columns.append(np.ones_like(time))
    if drift:
        columns.append(time)
    return np.stack(columns, axis=1)
