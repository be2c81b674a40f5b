"""What a fit is asked for: one object from the front door to the normal equations."""

import equinox as eqx

from identification.campaign.types import Campaign
from identification.fit.unknowns.measured import Measured
from identification.fit.unknowns.unknowns import DEFAULT_FREE
from scdpr_jax.robot.parameters import Robot, exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace


class FitOptions(eqx.Module):
    """What a fit of a campaign is asked for; the default is what suits most campaigns."""

    free: tuple[str, ...] = eqx.field(converter=tuple, static=True, default=DEFAULT_FREE)
    """Names of the quantities to estimate. Each nominal pretension has an effective one."""
    hold_out: tuple[str, ...] = eqx.field(converter=tuple, static=True, default=())
    """Names of runs that say nothing about the shared quantities; their own circumstances are
    estimated once these are known, to predict them."""
    measured: tuple[Measured, ...] = eqx.field(converter=tuple, default=())
    """What was measured otherwise: it counts as a measurement of its own, and a quantity that
    was is free."""
    clock_drifts: bool = eqx.field(static=True, default=False)
    """Whether the cameras' clocks may drift: a rate for each run is then estimated with its
    offset."""
    robot: Robot | None = None
    """What isn't estimated, and where the search for the rest begins; None for the consistent
    prototype. What the campaign says of the rig replaces it."""

    @property
    def all_free(self) -> tuple[str, ...]:
        """Names of all quantities that the fit frees, those measured otherwise among them."""
        otherwise = (name for number in self.measured for name in number.frees)
        return tuple(dict.fromkeys((*self.free, *otherwise)))

    def prior(self, campaign: Campaign) -> Robot:
        """The robot with what isn't free, and the start of what is.

        Args:
            campaign: The campaign, which may say more of the rig.

        Returns:
            The robot, with exact friction.
        """
        return exact(replace(self.robot or consistent(), campaign.robot))
