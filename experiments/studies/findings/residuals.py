"""What the fit leaves of the runs: which channels have more than noise, and how it looks."""

import dataclasses
import math

from experiments.page.coordinates import COORDINATES
from experiments.page.number_text import plain
from identification.fit.comparison import ENCODERS, Channel, Comparison
from identification.judge.validation import LEVEL, validate
from identification.result.estimate import Estimate
from scdpr_jax.robot.quantities import value

_LISTED = 3  # runs that are named one by one


@dataclasses.dataclass(frozen=True)
class Excess:
    """A channel whose residual is more than noise."""

    run: str
    """Name of the run."""
    channel: Channel
    """The channel."""
    size: float
    """Root mean square of the residual at the end-effector [m]; of a rotation [rad]."""

    @property
    def size_text(self) -> str:
        """The size in the unit that it is read in, "0.31 mm" or "0.2°"."""
        if self.channel.name == "delta_e":
            return f"{plain(math.degrees(self.size))}°"
        return f"{plain(1e3 * self.size)} mm"


@dataclasses.dataclass(frozen=True)
class Whiteness:
    """How many channels leave white residuals, uncorrelated with the voltages."""

    tested: int
    """Channels that are long enough to test."""
    following: int
    """Those whose residuals follow the voltages."""
    hanging: int
    """Others whose residuals are correlated over time."""

    @property
    def white(self) -> int:
        """Those that leave noise, or an encoder's rounding."""
        return self.tested - self.following - self.hanging


def excesses(estimate: Estimate) -> tuple[Excess, ...]:
    """Channels of the fitted runs whose residuals are more than noise, the worst first.

    Args:
        estimate: The estimate.

    Returns:
        The channels, by how far they exceed the noise.
    """
    radius = float(value(estimate.robot, "effective_radius"))
    beyond = [
        Excess(run.name, channel, channel.rms * (radius if channel.name in ENCODERS else 1.0))
        for run in fitted_runs(estimate)
        for channel in run.channels
        if not channel.is_noise
    ]
    return tuple(sorted(beyond, key=lambda excess: -excess.channel.chi_square))


def fitted_runs(estimate: Estimate) -> tuple[Comparison, ...]:
    """The runs that were fitted.

    Args:
        estimate: The estimate.

    Returns:
        All that weren't held out.
    """
    return tuple(run for run in estimate.comparisons if not run.held_out)


def whiteness(estimate: Estimate) -> Whiteness:
    """What whiteness and independence say of the fitted and of the held-out runs.

    Args:
        estimate: The estimate.

    Returns:
        The channels' numbers.
    """
    channels = [channel for run in estimate.comparisons for channel in validate(run)]
    tested = [c for c in channels if c.is_rounding or not math.isnan(c.whiteness)]
    worse = [channel for channel in tested if channel.verdict != "noise"]
    following = sum(channel.independence < LEVEL for channel in worse)
    return Whiteness(len(tested), following, len(worse) - following)


def excess_sentence(estimate: Estimate, beyond: tuple[Excess, ...]) -> str:
    """Whether the fitted runs leave noise, in words.

    Args:
        estimate: The estimate.
        beyond: Its `excesses`.

    Returns:
        The sentence.
    """
    fitted = fitted_runs(estimate)
    total = sum(len(run.channels) for run in fitted)
    if not beyond:
        return (
            f"The residuals of all {total} channels of {len(fitted)} fitted runs may be the "
            "sensors' noise: the model explains what was measured."
        )
    # Each run once, by its worst channel.
    first = {excess.run: excess for excess in reversed(beyond)}
    worst = [excess for excess in beyond if first[excess.run] is excess][:_LISTED]
    listed = "; ".join(
        f"{excess.run}, {COORDINATES[excess.channel.name].symbol}: {excess.size_text} rms "
        f"({plain(math.sqrt(excess.channel.chi_square))} times the noise), worst at "
        f"{excess.channel.worst_time:.2f} s"
        for excess in worst
    )
    return (
        f"The residuals are NOT only noise: {len(beyond)} of {total} channels of the "
        f"{len(fitted)} fitted runs have more. The worst: {listed}. The model doesn't "
        "explain these, and the values are the best for this model only."
    )


def whiteness_sentence(counted: Whiteness) -> str:
    """How the residuals look, in words.

    Args:
        counted: The channels' numbers.

    Returns:
        The sentence.
    """
    return (
        f"Of {counted.tested} channels that are long enough to test, "
        f"{counted.white} leave white residuals, uncorrelated with the voltages, or an "
        f"encoder's rounding; {counted.following} are correlated with the voltages, and "
        f"{counted.hanging} more with themselves over time."
    )
