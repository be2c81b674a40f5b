"""What a tuned robot answers: its open loop, what its shapers leave, how its legs track."""

import dataclasses
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper, residual_vibration
from tuning.loop.plant import MotorPlant
from tuning.loop.responses import sampled_loop

_POINTS = 400
_LOWEST = 1e-2  # of the gain crossover
_HIGHEST = 0.9  # of the Nyquist frequency, where a sampled gain falls to nothing


class OpenLoop(NamedTuple):
    """Frequency response of the loop as the controller runs it."""

    angular_frequency: Float[np.ndarray, " points"]
    """Angular frequency [rad/s], up to near the Nyquist frequency."""
    gain: Float[np.ndarray, " points"]
    """Gain [dB]."""
    phase: Float[np.ndarray, " points"]
    """Phase, without jumps [°]."""


def open_loop(plant: MotorPlant, controller: PD, *, delay: int, crossover: float) -> OpenLoop:
    """The sampled open loop over frequency.

    Args:
        plant: The drive.
        controller: The controller.
        delay: Samples from a measurement to its command.
        crossover: Gain crossover, around which the plot is placed [rad/s].

    Returns:
        Gain and phase.
    """
    nyquist = np.pi / float(controller.period)
    omega = jnp.asarray(np.geomspace(_LOWEST * crossover, _HIGHEST * nyquist, _POINTS))
    over = jax.jit(jax.vmap(lambda w: sampled_loop(plant, controller, w, delay=delay)))
    response = np.asarray(over(omega))
    phase = np.degrees(np.unwrap(np.angle(response)))
    # The lowest frequency is integrated once: its phase is near -90 degrees.
    phase -= 360 * np.round((phase[0] + 90) / 360)
    return OpenLoop(np.asarray(omega), 20 * np.log10(np.abs(response)), phase)


@dataclasses.dataclass(frozen=True, eq=False)
class NamedShaper:
    """A shaper of a figure."""

    name: str
    """What it is called."""
    shaper: Shaper
    """Its impulses."""
    damping_ratio: float
    """Damping ratio that it meets [1]."""
    band: tuple[float, float]
    """Frequencies that it may meet [Hz]."""

    def residual(self, frequency: Float[np.ndarray, " points"]) -> Float[np.ndarray, " points"]:
        """Residual vibration over the frequency that the shaper meets.

        Args:
            frequency: Frequencies [Hz].

        Returns:
            Residual vibration [1], 1 for as much as without a shaper.
        """
        ratio = jnp.asarray(self.damping_ratio)
        return np.asarray(_residual(self.shaper, jnp.asarray(frequency), ratio))


@jax.jit
def _residual(
    shaper: Shaper, frequency: Float[Array, " points"], ratio: Float[Array, ""]
) -> Float[Array, " points"]:
    return jax.vmap(lambda f: residual_vibration(shaper, frequency=f, damping_ratio=ratio))(
        frequency
    )
