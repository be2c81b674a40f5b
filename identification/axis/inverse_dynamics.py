"""First guesses of an axis's parameters: inverse-dynamics least squares, no simulation."""

import numpy as np
import scipy.optimize
from jaxtyping import Float

from identification.axis.log import AxisLog

_CUBIC = 3  # order of the local polynomials: the lowest with an unbiased acceleration slope
_STANDSTILL = 0.02  # of the rms velocity: below it the friction isn't Coulomb's full force


def inverse_dynamics(
    log: AxisLog, *, gain: float, half_window: int
) -> Float[np.ndarray, "4"] | None:
    r"""Mass, viscous, Coulomb and offset that balance the smoothed forces best.

    $$ \min \lVert M \ddot q + F_v \dot q + F_c\, \mathrm{sgn}\, \dot q + o - g u \rVert,
       \qquad M, F_v, F_c \ge 0 $$

    Velocity and acceleration are those of local cubics (Savitzky–Golay), and voltage and
    sign pass the same smoothing, so that no lag comes between the terms. Noise and the
    loop around the axis bias the result: it is a start for the open-loop fit, no more.

    Args:
        log: The axis's log.
        gain: Force per volt [N/V].
        half_window: Samples to either side in a local cubic.

    Returns:
        Mass [kg], viscous [N s/m], Coulomb [N] and offset [N]; None where the window is
        longer than the log or the balance asks for no mass.
    """
    time, voltage, position = (
        np.asarray(column, dtype=float) for column in (log.time, log.voltage, log.position)
    )
    window = 2 * half_window + 1
    if len(time) < 2 * window:
        return None
    step = float(np.median(np.diff(time)))
    grid = np.arange(time[0], time[-1], step)
    position, voltage = np.interp(grid, time, position), np.interp(grid, time, voltage)

    # It brings `scipy.stats`, which takes as long to load as all else of a fit.
    from scipy.signal import savgol_filter

    def smooth(signal: Float[np.ndarray, " n"], order: int) -> Float[np.ndarray, " n"]:
        return savgol_filter(signal, window, _CUBIC, deriv=order, delta=step)

    velocity = smooth(position, 1)
    moving = np.abs(velocity) > _STANDSTILL * np.sqrt(np.mean(velocity**2))
    moving[:half_window] = moving[-half_window:] = False
    if np.sum(moving) < 2 * window:
        return None
    terms = [smooth(position, 2), velocity, smooth(np.sign(velocity), 0), np.ones_like(grid)]
    matrix = np.stack(terms, axis=1)[moving]
    scale = np.linalg.norm(matrix, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    fit = scipy.optimize.lsq_linear(
        matrix / scale, gain * smooth(voltage, 0)[moving], ([0, 0, 0, -np.inf], np.inf)
    )
    guess = fit.x / scale
    return guess if guess[0] > 0 else None
