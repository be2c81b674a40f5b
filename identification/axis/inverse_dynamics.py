"""First guesses of an axis's parameters: inverse-dynamics least squares, no simulation."""

from collections.abc import Sequence

import numpy as np
import scipy.optimize
from jaxtyping import Float

from identification.axis.record import AxisRecord
from scdpr_jax.robot.stated.ranges import RANGES

_CUBIC = 3  # order of the local polynomials: the lowest with an unbiased acceleration slope
_STANDSTILL = 0.02  # of the rms velocity: below it the friction isn't Coulomb's full force


OPPOSED = 0.5
"""Share of the force that a negative mass explains from which motion opposes it [1]."""


def inverse_dynamics(
    record: AxisRecord, *, gain: float, half_window: int
) -> Float[np.ndarray, "4"] | None:
    r"""Mass, viscous, Coulomb and offset that balance the smoothed forces best.

    $$ \min \lVert M \ddot q + F_v \dot q + F_c\, \mathrm{sgn}\, \dot q + o - g u \rVert,
       \qquad M, F_v, F_c \ge 0 $$

    Velocity and acceleration are those of local cubics (Savitzky–Golay), and voltage and
    sign pass the same smoothing, so that no lag comes between the terms. Noise and the
    loop around the axis bias the result: it is a start for the fit, no more.

    Args:
        record: The axis's record.
        gain: Force per volt [N/V].
        half_window: Samples to either side in a local cubic.

    Returns:
        Mass [kg], viscous [N s/m], Coulomb [N] and offset [N]; None where the window is
        longer than the pieces or the balance asks for no mass.
    """
    balance = _balance(record, gain=gain, half_window=half_window)
    if balance is None:
        return None
    matrix, force = balance
    scale = np.linalg.norm(matrix, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    fit = scipy.optimize.lsq_linear(matrix / scale, force, ([0, 0, 0, -np.inf], np.inf))
    guess = fit.x / scale
    return guess if guess[0] > 0 else None


def check_mass(
    guesses: Sequence[Float[np.ndarray, "4"]], record: AxisRecord, *, gain: float
) -> None:
    """Refuse a log whose accelerations make the axis heavier or lighter than one can be.

    Args:
        guesses: Inverse-dynamics fits.
        record: The axis's record.
        gain: Force per volt [N/V] or [N m/V].

    Raises:
        ValueError: If no axis has such a mass: a unit is wrong.
    """
    unit, gains = ("kg m^2", "N m/V") if record.log.is_rotary else ("kg", "N/V")
    least, most = RANGES[unit]
    mass = float(np.median([guess[0] for guess in guesses]))
    if not least <= mass <= most:
        length = record.log.position_unit
        period = float(np.median(np.diff(np.asarray(record.log.time))))
        raise ValueError(
            f"the log's accelerations make the axis {mass:.3g} {unit}, expected {least:g} to "
            f"{most:g} [{unit}], with a sample every {period:.3g} s, a motion of "
            f"{record.motion:.3g} {length} and a gain of {gain:g} {gains}. Check the units in "
            "the header, of `t` (milliseconds under [s] make it a millionfold) and of "
            "`position` (metres under [mm] a thousandfold), and `--gain`."
        )


def opposes(record: AxisRecord, *, gain: float) -> bool:
    """Whether an axis accelerates against its force, as no axis does.

    Args:
        record: The axis's record.
        gain: Force per volt [N/V].

    Returns:
        Whether a negative mass explains more of the force than none, and most of it, at
        every smoothing that tells anything.
    """
    verdicts = []
    for half_window in (3, 10, 30):
        balance = _balance(record, gain=gain, half_window=half_window)
        if balance is None:
            continue
        matrix, force = balance
        backwards = scipy.optimize.lsq_linear(
            matrix, force, ([-np.inf, -np.inf, -np.inf, -np.inf], [0, 0, 0, np.inf])
        )
        forwards = scipy.optimize.lsq_linear(matrix, force, ([0, 0, 0, -np.inf], np.inf))
        spread = float(np.sum((force - np.mean(force)) ** 2))
        left = (1 - OPPOSED) * spread / 2
        verdicts.append(backwards.cost < min(left, 0.5 * forwards.cost))
    return bool(verdicts) and all(verdicts)


def _balance(
    record: AxisRecord, *, gain: float, half_window: int
) -> tuple[Float[np.ndarray, "n 4"], Float[np.ndarray, " n"]] | None:
    """Terms of the balance at the samples that move, and the force there."""
    window = 2 * half_window + 1
    parts = [
        _piece(record, piece.start, piece.end, half_window)
        for piece in record.pieces
        if len(piece) >= 2 * window
    ]
    if not parts:
        return None
    terms, voltage = (np.concatenate(part) for part in zip(*parts, strict=True))
    speed = np.abs(terms[:, 1])
    moving = speed > _STANDSTILL * np.sqrt(np.mean(speed**2))
    if np.sum(moving) < 2 * window:
        return None
    return terms[moving], gain * voltage[moving]


def _piece(
    record: AxisRecord, start: int, end: int, half_window: int
) -> tuple[Float[np.ndarray, "n 4"], Float[np.ndarray, " n"]]:
    """Smoothed terms of the balance and smoothed voltage of a piece, without its ends."""
    time, position = record.time[start:end], record.position[start:end]
    voltage = np.asarray(record.log.voltage)[start:end]
    step = float(np.median(np.diff(time)))
    grid = np.arange(time[0], time[-1], step)
    position, voltage = np.interp(grid, time, position), np.interp(grid, time, voltage)

    # It brings `scipy.stats`, which takes as long to load as all else of a fit.
    from scipy.signal import savgol_filter

    def smooth(signal: Float[np.ndarray, " n"], order: int) -> Float[np.ndarray, " n"]:
        window = 2 * half_window + 1
        return savgol_filter(signal, window, _CUBIC, deriv=order, delta=step)

    velocity = smooth(position, 1)
    terms = [smooth(position, 2), velocity, smooth(np.sign(velocity), 0), np.ones_like(grid)]
    inner = slice(half_window, len(grid) - half_window)
    return np.stack(terms, axis=1)[inner], smooth(voltage, 0)[inner]
