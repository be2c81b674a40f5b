"""What a robot is told on a leg: as a law, and sample by sample."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from scdpr_jax.command.controller import Controller
from scdpr_jax.command.shaper import ShapedTrajectory, Shaper
from scdpr_jax.command.trajectory import Trajectory
from scdpr_jax.robot.fields import si


class Commands(eqx.Module):
    """A command law sample by sample, from a robot at rest on."""

    controller: Controller
    """The controller of both drives; a sample lasts its period."""
    reference: Float[Array | np.ndarray, "... samples 2"] = eqx.field(
        metadata=si("m", "x^*, y^*")
    )
    """Where the end-effector is to be, before shaping [m]."""
    commanded: Float[Array | np.ndarray, "... samples 2"] = eqx.field(metadata=si("m"))
    """Reference that the controller is given [m]."""
    afterwards: Bool[Array | np.ndarray, "... samples"]
    """The samples of rest that are judged: the commanded reference has ended."""
    feedforward: Float[Array | np.ndarray, "... samples 2"] | None = eqx.field(
        default=None, metadata=si("V")
    )
    """Commands that are added to the controller's [V]; None for none."""


class CommandLaw(eqx.Module):
    """A reference profile with its shaper and a controller: what a robot is told."""

    reference: Trajectory
    """The reference before shaping."""
    controller: Controller
    """The controller of both drives."""
    shaper: Shaper = eqx.field(default_factory=lambda: unshaped())
    """The impulses, applied to the reference as a whole."""

    @property
    def duration(self) -> Float[Array, "..."]:
        """Time until the commanded reference ends [s]."""
        return self.reference.duration + self.shaper.duration

    def commands(self, samples: int, *, judged: int | None = None) -> Commands:
        """The law at the controller's own period.

        Args:
            samples: Samples from the begin on, beyond the commanded reference's end.
            judged: Samples after that end that are judged; None for all there are.

        Returns:
            The commands.
        """
        period = self.controller.period
        time = period * jnp.arange(samples, dtype=period.dtype)
        shaped = ShapedTrajectory(self.reference, self.shaper)
        afterwards = time >= self.duration
        if judged is not None:
            afterwards &= jnp.cumsum(afterwards) <= judged
        return Commands(
            controller=self.controller,
            reference=jax.vmap(self.reference.position)(time),
            commanded=jax.vmap(shaped.position)(time),
            afterwards=afterwards,
        )


def unshaped(impulses: int = 1) -> Shaper:
    """The shaper that changes nothing: one impulse at once.

    Args:
        impulses: Its impulses, all but the first without amplitude.

    Returns:
        The shaper.
    """
    return Shaper(np.zeros(impulses), np.eye(1, impulses)[0])
