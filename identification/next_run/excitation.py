"""Excitations to choose from: torque steps, staircases, chirps, multisines and knocks."""

import dataclasses
import itertools
from collections.abc import Callable

import numpy as np
from jaxtyping import Bool, Float

STEP = 1e-2
"""Interval of a proposed voltage [s]."""

REST = 0.2
"""Rest before anything moves, from which the camera tells the start [s]."""

TAIL = 0.3
"""Time without voltage at the end, in which the robot rings [s]."""

KNOCK_TIME = 0.03
"""How long a knock lasts [s]: three intervals."""

KNOCK_FORCE = 45.0
"""Force of a knock [N]."""


@dataclasses.dataclass(frozen=True, eq=False)
class Excitation:
    """A run in open loop, from rest."""

    name: str
    """What it is."""
    start: tuple[float, float]
    """Pose of the end-effector to start from [m]."""
    voltage: Float[np.ndarray, "intervals 2"]
    """Commands, each held for `STEP` [V]."""
    knock: float = 0.0
    """Horizontal force on the end-effector for `KNOCK_TIME` after `REST`; 0 for none [N]."""
    designed: bool = False
    """Whether a search has changed it."""

    @property
    def shape(self) -> str:
        """What its voltages look like, "torque step"."""
        return self.name.split(",")[0]

    def replaced(self, voltage: Float[np.ndarray, "intervals 2"]) -> "Excitation":
        """The run with the voltages that a search has found.

        Args:
            voltage: The voltages [V].

        Returns:
            The run, named after what it began as.
        """
        return Excitation(f"{self.shape}, improved", self.start, voltage, self.knock, True)

    @property
    def duration(self) -> float:
        """Length of the log [s]."""
        return STEP * self.voltage.shape[0]


def moving(intervals: int) -> Bool[np.ndarray, " intervals"]:
    """In which intervals of a run voltages are allowed.

    Args:
        intervals: Intervals of the run.

    Returns:
        True between the rest at its begin and the tail at its end.
    """
    number = np.arange(intervals)
    return (number >= round(REST / STEP)) & (number < intervals - round(TAIL / STEP))


Shape = Callable[[Float[np.ndarray, " n"]], Float[np.ndarray, " n"]]
"""A voltage over its limit, over the time from its begin [s]."""


def _step(time: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    return np.where(time < time[-1] / 2, 1.0, 0.0)


def _reversal(time: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    return np.where(time < time[-1] / 2, 1.0, -1.0)


def _staircase(time: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    levels = np.array([0.3, 0.65, 1.0, -1.0, -0.65, -0.3])
    return levels[np.minimum((time / time[-1] * levels.size).astype(int), levels.size - 1)]


def _chirp(time: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    low, high = 0.5, 6.0
    return np.sin(2 * np.pi * (low * time + (high - low) * time**2 / (2 * time[-1])))


def _multisine(time: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    """Five harmonics with Schroeder's phases, doi:10.1109/TIT.1970.1054411."""
    harmonic = np.arange(1, 6)
    phase = -np.pi * harmonic * (harmonic - 1) / harmonic.size
    total = np.sum(np.cos(2 * np.pi * np.outer(time, harmonic) + phase[None]), axis=1)
    return total / np.max(np.abs(total))


SHAPES: tuple[tuple[str, Shape], ...] = (
    ("torque step", _step),
    ("reversed torque step", _reversal),
    ("staircase", _staircase),
    ("chirp 0.5 to 6 Hz", _chirp),
    ("multisine 1 to 5 Hz", _multisine),
)
"""What the catalogue is made of."""

WAYS: tuple[tuple[str, tuple[float, float]], ...] = (
    ("sideways", (1.0, 1.0)),
    ("upwards", (1.0, -1.0)),
    ("aslant", (1.0, 0.2)),
)
"""Shares of both motors: x moves with their sum, y with their difference."""

AMPLITUDES = (0.9, 0.6, 0.4, 0.25)
"""Shares of the voltage limit, the first that keeps within the frame is taken [1]."""


def catalogue(
    *, limit: float, duration: float, poses: tuple[tuple[float, float], ...]
) -> tuple[Excitation, ...]:
    """Every shape of the catalogue, each way, from each pose, at half and full length.

    Args:
        limit: Limit of the voltages [V].
        duration: Longest run [s].
        poses: Poses of the end-effector to start from [m].

    Returns:
        The excitations, at every amplitude; then a knock at each pose.

    Raises:
        ValueError: If the duration leaves too little time to move.
    """
    least = 2 * (REST + TAIL + 0.2)
    if duration < least:
        raise ValueError(
            f"`duration` must be {least:g} s or more, got {duration:g} s: a run rests for "
            f"{REST:g} s before it moves and for {TAIL:g} s after. Allow for a longer run."
        )
    lengths = (round(duration / 2 / STEP), round(duration / STEP))
    driven = [
        Excitation(
            f"{name}, {way}, {share:.0%}",
            pose,
            _commands(shape, length, share * limit * np.array(motors)),
        )
        for (name, shape), (way, motors), pose, length, share in itertools.product(
            SHAPES, WAYS, poses, lengths, AMPLITUDES
        )
    ]
    still = np.zeros((lengths[0], 2))
    knocks = [Excitation("knock", pose, still, KNOCK_FORCE) for pose in poses]
    return (*driven, *knocks)


def _commands(
    shape: Shape, intervals: int, amplitude: Float[np.ndarray, "2"]
) -> Float[np.ndarray, "intervals 2"]:
    voltage, moves = np.zeros((intervals, 2)), moving(intervals)
    time = STEP * np.arange(np.sum(moves))
    voltage[moves] = shape(time)[:, None] * amplitude
    return voltage
