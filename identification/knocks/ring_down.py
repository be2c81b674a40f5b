"""Natural frequency and damping from the free vibration after a knock."""

import dataclasses
import functools
from collections.abc import Callable, Sequence

import numpy as np
import scipy.special
from jaxtyping import Float

from identification.knocks.decay import Decay, fit_decay
from identification.knocks.decimation import Thinned, thinned
from identification.knocks.spectrum import natural_frequency
from identification.knocks.steadiness import Steadiness, steadiness
from scdpr_jax.numerics.long_run_variance import sandwich
from scdpr_jax.robot.fields import si

_FEWEST = 20  # samples: two modes and a drift take ten
_GROWTH = 1.06  # of a window over the next shorter one: some 16 are tried
_LATEST = 0.6  # of the record after the knock: a window has 40 % of it at the least
_CYCLES = 1.5  # periods in a window: fewer can't be told from a drift
_NYQUIST = 0.9  # of half the sampling rate: beyond it a mode is sampled twice a period
_HEAVY = 0.3  # damping ratio: a sliding carriage's transient, not a vibration to shape for
_LEVEL = 0.01  # significance at which residuals are called more than noise
_EVIDENCE = 10.0  # of Schwarz's criterion: "very strong" (Kass and Raftery, 1995)
_ALIKE = 2.0  # standard errors by which two windows' residuals are no different
_SAME = 0.2  # of the frequency: further off, another window's strongest mode is another one
_DOUBTFUL = 0.25  # of the reciprocal length: a frequency less certain isn't resolved


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sensor:
    """What a ring-down was measured with, for messages."""

    name: str
    """Its name."""
    noise: float
    """Standard deviation of its noise [in its SI unit]."""
    unit: str
    """Unit that its numbers are told in."""
    factor: float
    """How many of these an SI unit is."""


@dataclasses.dataclass(frozen=True)
class Mode:
    """One vibration mode in a ring-down."""

    frequency: float
    r"""Natural frequency $\omega_n / 2\pi$, not the damped one [Hz]."""
    frequency_sigma: float
    """Its standard error [Hz]."""
    damping_ratio: float
    """Damping ratio [1], not below 0."""
    damping_ratio_sigma: float
    """Its standard error, before the bound at 0 [1]."""
    amplitude: float
    """Amplitude at the start of the window [m]."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class RingDown:
    """A knock's free vibration: its strongest mode, and how well that is known."""

    frequency: float = dataclasses.field(metadata=si("Hz", "f_n"))
    """Natural frequency of the strongest mode [Hz]."""
    frequency_sigma: float = dataclasses.field(metadata=si("Hz"))
    """Its standard error [Hz]."""
    damping_ratio: float = dataclasses.field(metadata=si("1", r"\zeta"))
    """Its damping ratio [1], not below 0."""
    damping_ratio_sigma: float = dataclasses.field(metadata=si("1"))
    """Standard error of the damping ratio, before the bound at 0 [1]."""
    amplitude: float = dataclasses.field(metadata=si("m"))
    """Its amplitude at the start of the window [m]."""
    fft_frequency: float = dataclasses.field(metadata=si("Hz"))
    """The same by the paper's peak picking in the same window [Hz], see `spectrum`."""
    fft_resolution: float = dataclasses.field(metadata=si("Hz"))
    """Reciprocal length of the window [Hz], what the peak picking can tell apart."""
    window: tuple[float, float] = dataclasses.field(metadata=si("s"))
    """First and last time of the samples that were fitted [s]."""
    chi_square: float = dataclasses.field(metadata=si("1"))
    """Residual variance over the camera's, 1 for noise alone [1]."""
    modes: tuple[Mode, ...]
    """All modes, the strongest first."""
    residuals_are_noise: bool
    """Whether the decay leaves nothing but the camera's noise; if not, the carriages are
    still sliding, frequency and damping depend on amplitude, and the standard errors are
    widened by what it leaves."""


@dataclasses.dataclass(frozen=True, eq=False)
class _Window:
    """The best model of one window."""

    start: float
    fit: Decay
    chi_square: float
    neighbours: float
    is_quiet: bool
    steadiness: Steadiness
    is_noise: bool


def ring_down(
    time: Float[np.ndarray, " samples"],
    displacement: Float[np.ndarray, " samples"],
    *,
    noise_sigma: float,
    after: float,
    sensor: Sensor | None = None,
) -> RingDown:
    r"""Fit decaying sines to the free vibration after a knock.

    $$ x(t) = \sum_i A_i e^{-\zeta_i \omega_i t}
       \cos\!\big(\sqrt{1 - \zeta_i^2}\, \omega_i t + \phi_i\big) + o \;[\,+ d\,t\,] $$

    A knock sets the carriages sliding. While they slide, the decay isn't exponential and
    the frequency differs; once friction holds both, what remains is a linear vibration of
    the end-effector between held carriages. So the window starts as early as it can with
    residuals that are the camera's noise, or no more than those of a later window that are.
    Where it can't, it starts where they are nearest to it, and says so. That frequency and
    damping don't change within it is tested by itself (`steadiness`). In each window one or
    two modes, with or without drift, are chosen by Schwarz's criterion; only modes that
    vibrate (damping ratio below 0.3) are allowed.

    This runs in NumPy: the number of samples changes from window to window, and there is
    nothing to compile. Of a long fast record means are fitted (`decimation`), so that a knock
    takes some tenths of a second at any rate.

    Args:
        time: Time of each sample [s], strictly increasing.
        displacement: Horizontal displacement of the end-effector [m], NaN where lost.
        noise_sigma: Standard deviation of the camera's position [m].
        after: Earliest time of the window [s]: the end of the knock, with a margin for
            what isn't known of the camera's clock.
        sensor: What measured it, for messages; default: the camera.

    Returns:
        The ring-down.

    Raises:
        ValueError: If there are too few samples, or no vibration stands out of the noise.
    """
    sensor = sensor or Sensor(name="camera", noise=noise_sigma, unit="mm", factor=1e3)
    if not noise_sigma > 0:
        raise ValueError(
            f"`noise_sigma` must be positive [m], got {noise_sigma}. It is the camera's "
            "standard deviation of a position, 0.19 mm on the paper's rig."
        )
    seen = np.isfinite(displacement) & (time >= after)
    time, displacement = time[seen], displacement[seen]
    _check_length(time, after=after)
    # In units of the noise from here on, but for the amplitudes.
    record = thinned(time, displacement / noise_sigma)
    windows = []
    for start in _starts(float(time[0]), float(time[-1])):
        inside = record.time >= start
        window = _window(record.time[inside], record.signal[inside])
        windows += [] if window is None else [window]
        if windows and windows[-1].is_noise:
            break
    if not windows:
        raise ValueError(_silence(time, sensor))
    if windows[-1].is_noise:
        chosen = _earliest_alike(windows)
    else:
        chosen = min(windows, key=lambda window: window.chi_square)
    unit = functools.partial(_in_metres, record, noise_sigma)
    modes = _ranked(chosen, unit)
    if not chosen.is_noise:
        later = windows[len(windows) // 2 :]
        modes[0] = _widened(modes[0], [_ranked(w, unit)[0] for w in later])
    quiet = [window for window in windows if window.is_quiet and window.start < chosen.start]
    if chosen.is_noise and quiet:
        modes[0] = _unless_steady(
            modes[0], quiet[0].steadiness.weight, _ranked(quiet[0], unit)[0]
        )
    inside = time >= chosen.start
    peak = natural_frequency(time[inside], displacement[inside])
    return RingDown(
        # A ring-down's own numbers are those of its strongest mode.
        **vars(modes[0]),
        fft_frequency=peak.frequency,
        fft_resolution=peak.resolution,
        window=(chosen.start, float(time[-1])),
        chi_square=chosen.chi_square,
        modes=tuple(modes),
        residuals_are_noise=chosen.is_noise,
    )


def _starts(first: float, last: float) -> Float[np.ndarray, " windows"]:
    """Where the windows start [s]: at the knock, then so long before the record's end.

    Their lengths are powers of one number and know nothing of the knock. So what isn't known
    of its end decides which windows there are, and not where any of them starts.
    """
    span = last - first
    longest, shortest = np.log([span, span * (1 - _LATEST)]) / np.log(_GROWTH)
    powers = np.arange(np.floor(longest), shortest, -1)
    return np.concatenate([[first], last - _GROWTH**powers])


def _check_length(time: Float[np.ndarray, " samples"], *, after: float) -> None:
    """Refuse a record that is too short to be split into windows."""
    needed = int(np.ceil(_FEWEST / (1 - _LATEST)))
    if len(time) < needed:
        raise ValueError(
            f"{len(time)} samples with a position after {after:.3g} s, expected at least "
            f"{needed} to tell a decay from noise. Record for longer after the knock, or "
            "check the camera's view of the marker."
        )


def _silence(time: Float[np.ndarray, " samples"], sensor: Sensor) -> str:
    """What to say when nothing rings."""
    # What four more parameters have to gain, as the amplitude of a lasting sine.
    gain = 4 * np.log(len(time)) + _EVIDENCE
    unit, noise = sensor.unit, sensor.factor * sensor.noise
    least = noise * np.sqrt(2 * gain / len(time))
    return (
        f"no vibration stands out between {time[0]:.3g} s and {time[-1]:.3g} s: the knock "
        f"rang less than about {least:.2g} {unit}, expected more than that over the "
        f"{sensor.name}'s {noise:.2g} {unit} noise. Knock harder, or leave this run out."
    )


def _window(
    time: Float[np.ndarray, " samples"], signal: Float[np.ndarray, " samples"]
) -> _Window | None:
    """The best model of a window, None if no vibration stands out in it."""
    if len(time) < _FEWEST:
        return None
    t, count = time - time[0], len(time)
    band = (_CYCLES / t[-1], _NYQUIST * 0.5 / float(np.median(np.diff(t))))
    if band[0] >= band[1]:
        return None
    models, silent = [], []
    for drift in (False, True):
        line = np.stack([np.ones(count), t][: 1 + drift], axis=1)
        rest = signal - line @ np.linalg.lstsq(line, signal, rcond=None)[0]
        silent.append(_schwarz(rest, 1 + drift))
        first = fit_decay(t, signal, band=band, drift=drift)
        models.append(first)
        models.append(fit_decay(t, signal, band=band, drift=drift, beside=first))
    scored = [
        (_schwarz(fit.residuals, fit.jacobian.shape[1]), i, fit)
        for i, fit in enumerate(models)
        if _vibrates(fit, band=band)
    ]
    if not scored or min(scored)[0] > min(silent) - _EVIDENCE:
        return None
    fit = min(scored)[2]
    chi_square, neighbours, quiet = _judge(fit)
    steady = steadiness(fit, t)
    is_noise = quiet and steady.likely
    return _Window(float(time[0]), fit, chi_square, neighbours, quiet, steady, is_noise)


def _earliest_alike(windows: Sequence[_Window]) -> _Window:
    """The first window whose residuals are no more than those of the last, which are noise.

    One knock in fifty is taken for more than noise by chance, often over many windows, and
    what is left after them tells the frequency ten times worse. Then the early samples leave
    no more than the late ones do; where carriages still slide, they leave much more.
    """
    last = windows[-1]
    for window in windows:
        fewer, more = len(last.fit.residuals), len(window.fit.residuals)
        # The last window is a part of the other: what they share makes no difference.
        apart = _ALIKE * np.sqrt(1 / fewer - 1 / more)
        louder = window.chi_square > last.chi_square * (1 + np.sqrt(2) * apart)
        alike = not louder and window.neighbours <= last.neighbours + apart
        if alike and window.steadiness.likely:
            return dataclasses.replace(window, is_noise=True)
    return last


def _schwarz(residuals: Float[np.ndarray, " samples"], parameters: int) -> float:
    """Schwarz's (Bayesian) information criterion for noise of unit size [1]."""
    return float(residuals @ residuals) + parameters * float(np.log(len(residuals)))


def _vibrates(fit: Decay, *, band: tuple[float, float]) -> bool:
    """Whether all modes are lightly damped, inside the band, resolved and apart."""
    frequency = fit.angular_frequency / (2 * np.pi)
    if np.any(frequency < band[0]) or np.any(frequency > band[1]):
        return False
    # A mode within another's half-power width is that mode's change with its amplitude, while
    # carriages slide: both together fit, and neither is one of the robot's.
    if frequency.size > 1 and np.ptp(frequency) < np.abs(fit.rate).sum() / (2 * np.pi):
        return False
    normal = fit.jacobian.T @ fit.jacobian
    scale = np.sqrt(np.diag(normal))
    if not np.all(scale > 0) or np.linalg.cond(normal / np.outer(scale, scale)) > 1e10:
        return False
    modes = _modes(fit, np.linalg.inv(normal))
    ratio = fit.rate / np.hypot(fit.rate, fit.angular_frequency)
    doubtful = _DOUBTFUL * band[0] / _CYCLES
    return all(
        mode.frequency_sigma < doubtful and -3 * mode.damping_ratio_sigma <= value <= _HEAVY
        for mode, value in zip(modes, ratio, strict=True)
    )


def _judge(fit: Decay) -> tuple[float, float, bool]:
    """Residual variance over the noise's, neighbours' correlation, and whether it is noise."""
    count, parameters = fit.jacobian.shape
    freedom = count - parameters
    total = float(fit.residuals @ fit.residuals)
    likely = scipy.special.chdtrc(freedom, total) > _LEVEL
    neighbours = float(fit.residuals[1:] @ fit.residuals[:-1]) / total
    # Under noise the correlation of neighbours is normal with a variance of 1/n.
    loose = neighbours * np.sqrt(count) < -scipy.special.ndtri(_LEVEL)
    return total / freedom, neighbours, bool(likely and loose)


def _in_metres(record: Thinned, noise_sigma: float, mode: Mode) -> Mode:
    """A mode of a record in units of its noise, with its amplitude in metres."""
    metres = noise_sigma * record.amplitude(mode.frequency) * mode.amplitude
    return dataclasses.replace(mode, amplitude=metres)


def _ranked(window: _Window, unit: Callable[[Mode], Mode]) -> list[Mode]:
    """A window's modes with their standard errors, the strongest first."""
    modes = map(unit, _modes(window.fit, _covariance(window)))
    return sorted(modes, key=lambda mode: -mode.amplitude)


def _widened(mode: Mode, others: list[Mode]) -> Mode:
    """A mode whose standard errors reach as far as it wanders in the later windows."""
    same = [o for o in others if abs(o.frequency / mode.frequency - 1) < _SAME]
    frequency = max((abs(o.frequency - mode.frequency) for o in same), default=0.0)
    ratio = max((abs(o.damping_ratio - mode.damping_ratio) for o in same), default=0.0)
    return dataclasses.replace(
        mode,
        frequency_sigma=float(np.hypot(mode.frequency_sigma, frequency)),
        damping_ratio_sigma=float(np.hypot(mode.damping_ratio_sigma, ratio)),
    )


def _unless_steady(mode: Mode, weight: float, early: Mode) -> Mode:
    """A mode whose standard errors allow for an earlier window that changed by chance.

    One steady ring-down in ten is called changing, and a later window that is taken for that
    errs the same way: the variance is that over both models.
    """
    if abs(early.frequency / mode.frequency - 1) > _SAME:
        return mode
    frequency = np.sqrt(weight) * (early.frequency - mode.frequency)
    ratio = np.sqrt(weight) * (early.damping_ratio - mode.damping_ratio)
    return dataclasses.replace(
        mode,
        frequency_sigma=float(np.hypot(mode.frequency_sigma, frequency)),
        damping_ratio_sigma=float(np.hypot(mode.damping_ratio_sigma, ratio)),
    )


def _covariance(window: _Window) -> Float[np.ndarray, "parameters parameters"]:
    """Covariance of all parameters, widened where the residuals are more than noise.

    Noise has unit size. Anything else is scaled to the residuals, and to the larger of
    white and correlated (`long_run_variance.sandwich`) for each parameter.
    """
    fit = window.fit
    # Residuals smaller than the noise are luck, and no reason for a smaller error.
    scale = max(1.0, window.chi_square)
    white = scale * np.linalg.inv(fit.jacobian.T @ fit.jacobian)
    if window.is_noise:
        return white
    correlated = sandwich(fit.jacobian, fit.residuals).covariance
    growth = np.sqrt(np.maximum(1.0, np.diag(correlated) / np.diag(white)))
    return white * np.outer(growth, growth)


def _modes(fit: Decay, covariance: Float[np.ndarray, "parameters parameters"]) -> list[Mode]:
    r"""Natural frequency $\sqrt{\omega^2 + \sigma^2}$ and ratio $\sigma / \omega_n$."""
    modes, count = [], len(fit.rate)
    for i, (omega, rate) in enumerate(zip(fit.angular_frequency, fit.rate, strict=True)):
        natural = np.hypot(omega, rate)
        by_frequency = np.array([omega, rate]) / natural / (2 * np.pi)
        by_ratio = np.array([-rate * omega, omega**2]) / natural**3
        block = covariance[np.ix_([i, count + i], [i, count + i])]
        modes.append(
            Mode(
                frequency=float(natural / (2 * np.pi)),
                frequency_sigma=float(np.sqrt(by_frequency @ block @ by_frequency)),
                # Nothing in a passive robot feeds a vibration: a ratio below 0 is noise.
                damping_ratio=max(0.0, float(rate / natural)),
                damping_ratio_sigma=float(np.sqrt(by_ratio @ block @ by_ratio)),
                amplitude=float(fit.amplitude[i]),
            )
        )
    return modes
