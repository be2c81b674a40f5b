r"""Whether knocks ring as their settings say: labels that were mixed up, or forgotten.

The natural frequency goes with the root of the tension, over a height that the geometry alone
gives: $f \propto \sqrt{T}\, g(y)$. So every knock tells how taut the loop was, in proportion.
On rigs with elastic cables and sliding carriages the knocks of one setting agree to 3 % of the
tension, 8 % at the worst; a forgotten turn of the tensioner is ten times that.
"""

import dataclasses
import itertools

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from identification.knocks.frequency_map import FrequencyMap
from scdpr_jax.linear.modes import BOTH_HELD, natural_frequencies
from scdpr_jax.robot.parameters import Robot

ODD = 0.15
"""Difference of a tension's logarithm from its setting's from which a knock is odd [1]."""

APART = 0.1
"""Difference of two settings' logarithms from which they should ring differently [1]."""

ALIKE = 0.2
"""Share of that difference below which they ring alike [1]."""

SURE = 3.0
"""Standard errors that a difference has to be of, too."""


@dataclasses.dataclass(frozen=True)
class OddKnocks:
    """Knocks that ring otherwise than the rest of their setting."""

    setting: float
    """Nominal pretension of their label [N]."""
    runs: tuple[str, ...]
    """Their names; all knocks of the setting where it can't be said which are odd."""
    ratio: float
    """Tension that they ring at over the rest's [1]."""
    rings_as: float | None
    """Another setting whose knocks ring as they do [N]."""


@dataclasses.dataclass(frozen=True)
class AlikeSettings:
    """Two settings whose knocks ring as if they were one."""

    settings: tuple[float, float]
    """Their nominal pretensions [N]."""
    ratio: float
    """Tension that the second one's knocks ring at over the first one's [1]."""


def odd_knocks(frequencies: FrequencyMap, robot: Robot) -> tuple[OddKnocks, ...]:
    """Knocks that ring otherwise than their setting.

    Args:
        frequencies: The knocks.
        robot: The rig's geometry and masses, at any pretension.

    Returns:
        One for each setting that has some.
    """
    tension, sigma = _log_tensions(frequencies, robot)
    settings = np.unique(frequencies.pretension)
    middle = {s: float(np.median(tension[frequencies.pretension == s])) for s in settings}
    odd = []
    for setting in settings:
        own = np.flatnonzero(frequencies.pretension == setting)
        off = tension[own] - middle[setting]
        rows = own[np.abs(off) > np.maximum(ODD, SURE * sigma[own])]
        if not rows.size:
            continue
        level = float(np.median(tension[rows]))
        others = [s for s in settings if s != setting and abs(middle[s] - level) < ODD / 2]
        named = rows if 2 * rows.size < own.size else own
        odd.append(
            OddKnocks(
                setting=float(setting),
                runs=tuple(frequencies.runs[row] for row in named),
                ratio=float(np.exp(np.ptp(tension[own]) * np.sign(level - middle[setting]))),
                rings_as=float(others[0]) if others else None,
            )
        )
    return tuple(odd)


def alike_settings(frequencies: FrequencyMap, robot: Robot) -> tuple[AlikeSettings, ...]:
    """Settings whose knocks ring as if they were one.

    Args:
        frequencies: The knocks.
        robot: The rig's geometry and masses, at any pretension.

    Returns:
        One for each pair of neighbouring settings that does.
    """
    tension, _ = _log_tensions(frequencies, robot)
    settings = np.unique(frequencies.pretension)
    pairs = []
    for low, high in itertools.pairwise(settings.tolist()):
        expected = float(np.log(high / low)) if low > 0 else np.inf
        first, second = (
            float(np.median(tension[frequencies.pretension == s])) for s in (low, high)
        )
        if expected >= APART and abs(second - first) < ALIKE * expected:
            pairs.append(
                AlikeSettings((float(low), float(high)), float(np.exp(second - first)))
            )
    return tuple(pairs)


def _log_tensions(
    frequencies: FrequencyMap, robot: Robot
) -> tuple[Float[np.ndarray, " knocks"], Float[np.ndarray, " knocks"]]:
    """Logarithms of the tensions that the knocks ring at, and their standard errors [1]."""
    expected = np.asarray(_lowest(robot, jnp.asarray(frequencies.y)))
    tension = 2 * np.log(frequencies.frequency / expected)
    return tension, 2 * frequencies.frequency_sigma / frequencies.frequency


@jax.jit
def _lowest(robot: Robot, height: Float[Array, " knocks"]) -> Float[Array, " knocks"]:
    """The lowest natural frequency with both carriages held, at each height [Hz]."""
    return jax.vmap(lambda y: natural_frequencies(robot, y, BOTH_HELD)[0])(height)
