"""The vibrations after the knocks: measured and fitted decays, and the model's frequencies."""

import dataclasses

import jax
import numpy as np
from jaxtyping import Array, Float

from experiments.page.number_text import percent, plain
from identification.campaign.types import Campaign, Run
from identification.knocks.frequency_map import FrequencyMap
from identification.knocks.ring_down import RingDown
from identification.knocks.spectrum import amplitude_spectrum
from identification.result.estimate import Estimate
from scdpr_jax.linear.modes import BOTH_HELD, natural_frequencies
from scdpr_jax.robot.parameters import Robot

_HEIGHTS = 60  # points of a model's curve
_CLEAR = 0.05  # m between end-effector and frame: nearer the frequency rises without limit
_POINTS = 500  # of a decay's curve


@dataclasses.dataclass(frozen=True, eq=False)
class KnockDecay:
    """A knock's free vibration: its samples, the fitted decay and the spectrum."""

    run: str
    """Name of the run."""
    time: Float[np.ndarray, " samples"]
    """Time of the frames on the camera's clock [s]."""
    displacement: Float[np.ndarray, " samples"]
    """Horizontal position of the end-effector [m], NaN where lost."""
    ring_down: RingDown
    """The fitted modes."""
    curve_time: Float[np.ndarray, " points"]
    """Times within the fitted window [s]."""
    curve: Float[np.ndarray, " points"]
    """The fitted displacement at these [m]."""
    frequency: Float[np.ndarray, " bins"]
    """Frequencies of the spectrum [Hz]."""
    amplitude: Float[np.ndarray, " bins"]
    """Amplitudes of the measured displacement [m]."""


@dataclasses.dataclass(frozen=True, eq=False)
class ModelCurve:
    """Natural frequencies of a model over the height of the end-effector."""

    height: Float[np.ndarray, " heights"]
    """Height of the end-effector [m]."""
    frequency: Float[np.ndarray, "heights 2"]
    """Natural frequencies with both carriages held [Hz], ascending."""


def knock_decays(
    campaign: Campaign, frequencies: FrequencyMap, *, most: int
) -> tuple[KnockDecay, ...]:
    """The decays of the first knocks of a map.

    Args:
        campaign: The campaign that the map was made from.
        frequencies: The map.
        most: Knocks that are looked at.

    Returns:
        One for each of these; none for a map that was read from a file.
    """
    pairs = zip(frequencies.runs, frequencies.ring_downs, strict=False)
    return tuple(knock_decay(campaign.run(name), fit) for name, fit in tuple(pairs)[:most])


def knock_decay(run: Run, fit: RingDown) -> KnockDecay:
    """The curve that a ring-down's frequencies and damping ratios stand for.

    Amplitudes, phases and drift follow from the samples by linear least squares.

    Args:
        run: The run; it has a camera.
        fit: Its ring-down.

    Returns:
        Samples, curve and spectrum.
    """
    time, displacement = run.camera.time, run.camera.position[:, 0]
    first, last = fit.window
    used = np.isfinite(displacement) & (time >= first) & (time <= last)
    t, x = time[used], displacement[used]
    coefficients = np.linalg.lstsq(_basis(t - first, fit), x, rcond=None)[0]
    fine = np.linspace(first, last, _POINTS)
    return KnockDecay(
        run.name,
        time,
        displacement,
        fit,
        fine,
        _basis(fine - first, fit) @ coefficients,
        *amplitude_spectrum(t, x),
    )


def _basis(time: Float[np.ndarray, " n"], fit: RingDown) -> Float[np.ndarray, "n columns"]:
    columns = [np.ones_like(time), time]
    for mode in fit.modes:
        omega = 2 * np.pi * mode.frequency
        envelope = np.exp(-mode.damping_ratio * omega * time)
        turned = omega * np.sqrt(1 - mode.damping_ratio**2) * time
        columns += [envelope * np.cos(turned), envelope * np.sin(turned)]
    return np.stack(columns, axis=1)


def model_curves(
    campaign: Campaign, estimate: Estimate, frequencies: FrequencyMap
) -> dict[float, ModelCurve]:
    """The model's natural frequencies at the settings that were both knocked and fitted.

    Args:
        campaign: The campaign.
        estimate: What was found in it.
        frequencies: The measured frequencies.

    Returns:
        Curves over the height by nominal pretension [N].
    """
    fitted = {p.setting for p in estimate.parameters if p.name == "effective_pretension"}
    curves = {}
    for run in campaign.runs:
        estimated = run.pretension_label in fitted or None in fitted
        measured = run.pretension in frequencies.pretension
        if estimated and measured and run.pretension not in curves:
            curves[run.pretension] = model_curve(estimate.of_setting(run.pretension_label))
    return curves


def model_curve(robot: Robot) -> ModelCurve:
    """Natural frequencies with both carriages held by friction, over the height.

    Args:
        robot: The robot at the pretension in question.

    Returns:
        The curve over the heights that the end-effector can reach.
    """
    low, high = map(float, robot.heights)
    height = np.linspace(low + _CLEAR, high - _CLEAR, _HEIGHTS)
    return ModelCurve(height, np.asarray(_over_height(robot, height)))


@jax.jit
def _over_height(robot: Robot, height: Float[Array, " heights"]) -> Float[Array, "heights 2"]:
    return jax.vmap(lambda y: natural_frequencies(robot, y, BOTH_HELD))(height)


def frequency_sentence(frequencies: FrequencyMap) -> str:
    """At which frequencies the knocks ring, in words.

    Args:
        frequencies: The map.

    Returns:
        The sentence.
    """
    low, high = float(frequencies.frequency.min()), float(frequencies.frequency.max())
    knocks = len(frequencies.runs)
    poses = "one pose" if knocks == 1 else f"{knocks} poses"
    lost = len(frequencies.unresolved)
    without = "" if lost == 0 else f" {lost} more gave none."
    return (
        f"Knocks at {poses} ring at {plain(low, 3)} to {plain(high, 3)} Hz, with damping "
        f"ratios up to {percent(float(frequencies.damping_ratio.max()))}.{without}"
    )
