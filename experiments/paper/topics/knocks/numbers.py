"""Figures 11 and 12: knocks, their spectra, and the natural frequency over the workspace."""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from identification.knocks.spectrum import SpectralPeak, amplitude_spectrum, natural_frequency
from scdpr_jax.command.sensors import Camera, frame_times, observe
from scdpr_jax.engines.stepping import Inputs, interpolate, simulate
from scdpr_jax.linear.modes import CONDITIONS, Condition, natural_frequencies
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import State, rest

SETTINGS = (200.0, 350.0, 500.0)
"""Nominal pretensions of section 5.2 [N]."""

MEASURED = {200.0: 2.4, 500.0: 3.9}
"""Natural frequency that section 5.2 reports for a nominal pretension [Hz]."""

COLUMNS = tuple(np.linspace(0.3, 1.9, 5).tolist())
"""Horizontal positions of the knocks [m]: five, over Table 3's range; none is printed."""

ROWS = tuple(np.linspace(0.2, 0.9, 4).tolist())
"""Heights of the knocks [m]: four, over Table 3's range; none is printed."""

HEIGHTS = tuple(np.linspace(0.17, 0.94, 60).tolist())
"""Heights of the drawn curves [m]: the end-effector clear of the guides by 3 cm."""

FORCE = 10.0
"""Force of a knock [N]; none is printed. Carriages mostly stay where friction holds them."""

_PERIOD, _INTERVALS = 1e-3, 4000
_KNOCK = 30  # intervals: a hand's push of 30 ms
_NOMINAL = 350.0


def effective_share() -> float:
    """Effective over nominal pretension of the default robot, whose 350 N are 85 N.

    Returns:
        The share [1].
    """
    return float(value(consistent(), "effective_pretension")) / _NOMINAL


def at_setting(setting: float) -> Robot:
    """The default robot at a nominal pretension, its coefficient of friction the same.

    Args:
        setting: Nominal pretension [N].

    Returns:
        The robot.
    """
    return replace(consistent(), {"effective_pretension": effective_share() * setting})


class Knock(NamedTuple):
    """A knock as the vision system records it, and its spectrum."""

    time: Float[np.ndarray, " frames"]
    """Times of the frames [s]."""
    displacement: Float[np.ndarray, " frames"]
    """Displacement of the end-effector about its mean [m]."""
    frequency: Float[np.ndarray, " bins"]
    """Frequencies of the spectrum [Hz]."""
    amplitude: Float[np.ndarray, " bins"]
    """Amplitude spectrum [m]."""
    peak: SpectralPeak
    """Its highest peak."""
    second: float
    """Height of the next peak over that of the highest, a period and a half apart [1]."""


@eqx.filter_jit
def _ring(
    pretension: Float[Array, " runs"], place: Float[Array, "runs 2"], force: Float[Array, ""]
) -> tuple[Float[Array, "runs samples 5"], Float[Array, "runs samples 5"]]:
    inputs = Inputs(
        jnp.full(_INTERVALS, _PERIOD),
        jnp.zeros((_INTERVALS, 2)),
        jnp.where(jnp.arange(_INTERVALS) < _KNOCK, force, 0.0),
    )

    def ring(
        tension: Float[Array, ""], at: Float[Array, "2"]
    ) -> tuple[Float[Array, "samples 5"], Float[Array, "samples 5"]]:
        robot = replace(consistent(), {"effective_pretension": tension})
        states = simulate(robot, rest(robot, at[0], at[0], at[1]), inputs)
        return states.position, states.velocity

    return jax.vmap(ring)(pretension, place)


@functools.cache
def fig11(force: float = FORCE) -> Knock:
    """Figure 11: one knock in the middle of the frame at 350 N, seen at 30 frames a second.

    Args:
        force: Force of the knock [N].

    Returns:
        Record, spectrum and peak.
    """
    tension = jnp.asarray([effective_share() * _NOMINAL])
    position, velocity = _ring(tension, jnp.asarray([[1.1, 0.55]]), jnp.asarray(force))
    key, noise = jax.random.split(jax.random.key(11))
    camera = Camera()
    begin = _KNOCK * _PERIOD
    count = int(30 * (_INTERVALS * _PERIOD - begin)) - 1
    times = frame_times(camera, count=count, key=key, start=begin)
    interval = jnp.floor(times / _PERIOD).astype(int)
    held = Inputs(jnp.full(_INTERVALS, _PERIOD), jnp.zeros((_INTERVALS, 2)), 0.0)
    seen = interpolate(
        State(position[0], velocity[0]),
        held,
        interval=interval,
        fraction=times / _PERIOD - interval.astype(times.dtype),
    )
    x = np.asarray(observe(camera, seen, key=noise))[:, 0]
    time = np.asarray(times)
    frequency, amplitude = amplitude_spectrum(time, x)
    peak = natural_frequency(time, x)
    apart = np.abs(frequency - peak.frequency) > 1.5 * peak.resolution
    beyond = apart & (frequency > 1.5 * peak.resolution)
    return Knock(
        time,
        x - x.mean(),
        frequency,
        amplitude,
        peak,
        float(amplitude[beyond].max() / peak.amplitude),
    )


class Level(NamedTuple):
    """First elastic mode of one carriage condition; it grows with the root of the tension."""

    condition: Condition
    """What holds the carriages."""
    middle: float
    """Frequency at mid-height for a tension of 1 N [Hz]."""
    rows: Float[np.ndarray, " rows"]
    """Frequency at the knocks' heights for a tension of 1 N [Hz]."""
    curve: Float[np.ndarray, " heights"]
    """Frequency over `HEIGHTS` for a tension of 1 N [Hz]."""

    def nominal(self, setting: float) -> float:
        """Frequency at mid-height, were the setting the tension.

        Args:
            setting: Nominal pretension [N].

        Returns:
            Frequency [Hz].
        """
        return self.middle * setting**0.5

    def share(self, setting: float) -> float:
        """Effective over nominal pretension that the reported frequency asks for.

        Args:
            setting: A nominal pretension of `MEASURED` [N].

        Returns:
            The share [1].
        """
        return (MEASURED[setting] / self.nominal(setting)) ** 2

    @property
    def rise(self) -> float:
        """Frequency at mid-height over the mean of the lowest and the highest row [1]."""
        return self.middle / float(np.mean(self.rows[[0, -1]]))


class Fig12(NamedTuple):
    """Natural frequencies over the workspace."""

    levels: tuple[Level, ...]
    """By the model's modes, one for each carriage condition."""
    peaks: Float[np.ndarray, "settings rows columns"]
    """By the paper's own procedure: knocks of the default robot, FFT, highest peak [Hz]."""
    gone: tuple[float, ...]
    """Share of the knocks of each setting after which a carriage rests elsewhere [1]."""

    def peak(self, setting: float) -> float:
        """Frequency at the two middle heights by knocks, averaged.

        Args:
            setting: Nominal pretension [N].

        Returns:
            Frequency [Hz].
        """
        return float(self.peaks[SETTINGS.index(setting), 1:3].mean())


@functools.cache
def fig12(force: float = FORCE) -> Fig12:
    """Figure 12: 4 × 5 poses and 3 pretensions, for each carriage condition and by knocks.

    Args:
        force: Force of the knocks [N].

    Returns:
        Frequencies.
    """
    settings, rows, columns = (np.array(part) for part in (SETTINGS, ROWS, COLUMNS))
    tension, y, x = np.meshgrid(effective_share() * settings, rows, columns, indexing="ij")
    position, _ = _ring(
        jnp.asarray(tension.ravel()),
        jnp.asarray(np.stack([x.ravel(), y.ravel()], axis=1)),
        jnp.asarray(force),
    )
    # Every 33rd sample after the knock: the camera's 30 frames a second.
    seen = np.asarray(position)[:, _KNOCK + 30 :: 33]
    time = _PERIOD * 33 * np.arange(seen.shape[1])
    peaks = np.array([natural_frequency(time, run[:, 0]).frequency for run in seen])
    moved = np.abs(np.asarray(position)[:, -1, 2:4] - x.reshape(-1, 1)).max(axis=1)
    return Fig12(
        levels=tuple(level(condition) for condition in CONDITIONS),
        peaks=peaks.reshape(tension.shape),
        # A millimetre: what the camera sees for certain.
        gone=tuple((moved.reshape(len(SETTINGS), -1) > 1e-3).mean(axis=1).tolist()),
    )


@functools.cache
def level(condition: Condition) -> Level:
    """The first elastic mode of a carriage condition over the height.

    Args:
        condition: What holds the carriages.

    Returns:
        Its frequencies.
    """
    middle = float(consistent().frame.height) / 2
    heights = np.concatenate([[middle], ROWS, HEIGHTS])
    first = np.asarray(_first_mode(jnp.asarray(heights), condition))
    return Level(condition, float(first[0]), first[1 : 1 + len(ROWS)], first[1 + len(ROWS) :])


@eqx.filter_jit
def _first_mode(
    heights: Float[Array, " heights"], condition: Condition
) -> Float[Array, " heights"]:
    robot = replace(consistent(), {"effective_pretension": 1.0})
    return jax.vmap(lambda y: natural_frequencies(robot, y, condition)[0])(heights)
