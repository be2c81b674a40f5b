r"""A knock's ring-down in an accelerometer's stream.

A decaying sine's second derivative is one of the same frequency and the same decay, so what is
fitted to a camera's positions is fitted to accelerations as they are; gravity is an offset.
Only amplitudes differ, by $\omega^2$: a fast mode that a camera hardly sees is large here, so
modes are ranked by the motion that they are.
"""

import dataclasses
import math

import numpy as np
from jaxtyping import Float

from identification.campaign.types import AccelerometerStream
from identification.knocks.ring_down import Mode, RingDown, Sensor, ring_down

_REST = 25
"""Samples of rest before a knock that tell the noise: it is known to 14 %."""
_OUT = 6.0
"""Times the noise from which on an acceleration is a knock's [1]."""
_MARGIN = 0.03
"""Between the end of a knock and the first sample in use [s]: a push has no sharp end."""
_USUAL = 0.03
"""Duration of a knock by hand where nobody states it [s]."""
_ORDER = 6
"""Order of the differences that leave the noise: of a vibration that is sampled ten times in a
period they leave 3 %."""
_CLOCK = 1e-4
"""What the clock of a cheap chip's logger, or of a phone, may be off by [1]: two crystals."""
_NEAR = 0.5
"""How far the first motion may be from the stated knock for both to be one [s]: the clocks of
drive and accelerometer needn't agree."""


def accelerometer_ring_down(
    stream: AccelerometerStream, *, stated: tuple[float, float] | None
) -> RingDown:
    """Natural frequency and damping of a knock, by the accelerometer.

    Args:
        stream: The accelerometer's stream.
        stated: Start and end of the knock on the drive's clock [s], None where nobody says.

    Returns:
        The ring-down; its amplitudes are displacements.

    Raises:
        ValueError: If no knock stands out, or no vibration follows it.
    """
    time, values = stream.time, stream.along
    begin = _onset(time, values)
    if begin is None and stated is None:
        raise ValueError(
            "no knock stands out of the accelerometer's noise, expected a push of some m/s^2 "
            "after a rest. State [knock] in run.toml, or knock harder."
        )
    length = _USUAL if stated is None else stated[1] - stated[0]
    if begin is None or (stated is not None and abs(begin - stated[0]) < _NEAR):
        # On one clock the stated end is better than one that starts at the noise's edge.
        end = stated[1] if begin is None else max(stated[1], begin + length)
    else:
        end = begin + length
    before = values[time < (end - length if begin is None else begin)]
    sensor = Sensor(
        name="accelerometer", noise=_noise(values, before), unit="m/s^2", factor=1.0
    )
    found = ring_down(
        time, values, noise_sigma=sensor.noise, after=end + _MARGIN, sensor=sensor
    )
    modes = tuple(sorted(map(_told_honestly, found.modes), key=lambda mode: -mode.amplitude))
    return dataclasses.replace(found, **vars(modes[0]), modes=modes)


def _told_honestly(mode: Mode) -> Mode:
    """A mode with its amplitude as a displacement, and with what its clock may be off by."""
    omega = 2 * math.pi * mode.frequency
    sigma = math.hypot(mode.frequency_sigma, _CLOCK * mode.frequency)
    return dataclasses.replace(mode, amplitude=mode.amplitude / omega**2, frequency_sigma=sigma)


def _onset(
    time: Float[np.ndarray, " samples"], values: Float[np.ndarray, " samples"]
) -> float | None:
    """The first acceleration that is a knock's [s], None where there is none."""
    first = values[:_REST]
    if len(values) < 4 * _REST:
        return None
    level = float(np.median(first))
    noise = 1.4826 * float(np.median(np.abs(first - level)))
    # A chip's last digit may be all the noise that it shows.
    digit = float(np.min(np.diff(np.unique(values)), initial=np.inf))
    out = np.abs(values - level) > _OUT * max(noise, digit / 2)
    # Twice in three samples: one alone may be a spike on the line.
    out &= np.convolve(out, [1, 1, 1], "same") >= 2
    if not out.any():
        return None
    begin = int(np.argmax(out))
    return float(time[begin]) if begin >= _REST else None


def _noise(values: Float[np.ndarray, " samples"], before: Float[np.ndarray, " _"]) -> float:
    """Standard deviation of the noise, by the rest before the knock and by fast differences.

    The larger of both counts: differences know it better where samples are many, and see too
    little where neighbours aren't independent.
    """
    step = np.diff(values, n=_ORDER)
    gain = math.sqrt(math.comb(2 * _ORDER, _ORDER))
    fast = 1.4826 * float(np.median(np.abs(step))) / gain
    still = float(np.std(before, ddof=1)) if len(before) >= _REST else 0.0
    noise = max(fast, still / (1 + 2 / math.sqrt(2 * max(len(before), 2))))
    # Half the rounding of a chip whose last digit is coarser than its noise.
    digit = float(np.min(np.diff(np.unique(values)), initial=np.inf))
    floor = digit / math.sqrt(12) if math.isfinite(digit) else 1e-12
    # What isn't known of it: a noise that is taken too small makes residuals of mere noise.
    return max(noise, floor) * (1 + 1.5 / math.sqrt(len(values)))


def joined(camera: RingDown, accelerometer: RingDown) -> RingDown:
    """A knock's ring-down by both of its sensors.

    Frequency and damping are means, each sensor weighed by what it knows. Where they disagree
    by more than they know, the errors grow by as much.

    Args:
        camera: By the camera, whose amplitudes and windows are kept.
        accelerometer: By the accelerometer.

    Returns:
        The ring-down.
    """
    numbers = {}
    for name in ("frequency", "damping_ratio"):
        pairs = [
            (getattr(r, name), getattr(r, f"{name}_sigma")) for r in (camera, accelerometer)
        ]
        numbers[name], numbers[f"{name}_sigma"] = _mean(*pairs)
    return dataclasses.replace(
        camera,
        **numbers,
        residuals_are_noise=camera.residuals_are_noise and accelerometer.residuals_are_noise,
    )


def _mean(first: tuple[float, float], second: tuple[float, float]) -> tuple[float, float]:
    """Weighted mean of two numbers with standard errors, and its own."""
    (a, sigma_a), (b, sigma_b) = first, second
    if not (sigma_a > 0 and sigma_b > 0):
        return (a, sigma_a) if sigma_a <= sigma_b else (b, sigma_b)
    weight = sigma_b**2 / (sigma_a**2 + sigma_b**2)
    apart = abs(a - b) / math.hypot(sigma_a, sigma_b)
    return weight * a + (1 - weight) * b, sigma_a * math.sqrt(weight) * max(1.0, apart)
