"""Which friction law an axis asks for: the usual one, or one that minds the direction."""

import dataclasses

import jax.numpy as jnp
import numpy as np

from identification.axis.drive_axis import (
    EXTENDED_NAMES,
    PARAMETER_NAMES,
    DriveAxisEstimate,
    delayed,
    estimate_drive_axis,
)
from identification.axis.log import AxisLog
from identification.axis.motion import axis_positions

FITTED_SHARE = 0.6
"""Share of the record that both laws are fitted to, before they predict the rest [1]."""

WORTH_IT = 0.95
"""Error of the extended law over the usual one's up to which it is preferred [1]."""


@dataclasses.dataclass(frozen=True, eq=False)
class AxisLaws:
    """The usual law and the extended one, each fitted to a part and predicting the rest."""

    usual_ahead: float
    """Open-loop error of the usual law in the part that it wasn't fitted to [m, rms]."""
    extended_ahead: float
    """The same of the extended law [m, rms]."""
    extended: DriveAxisEstimate
    """The extended law fitted to the whole record."""

    @property
    def extended_is_preferred(self) -> bool:
        """Whether the data that were held out prefer the extended law."""
        return self.extended_ahead < WORTH_IT * self.usual_ahead


def compare_axis_laws(
    log: AxisLog, usual: DriveAxisEstimate, *, gain: float, delay_samples: int = 0
) -> AxisLaws:
    r"""Whether viscous friction of its own in each direction predicts what wasn't fitted.

    $$ M \ddot q + (F_v + \mathrm{sgn}(\dot q)\,\Delta F_v / 2)\,\dot q
       + F_c\,\mathrm{Sgn}\,\dot q + o \ni g u $$

    Both laws are fitted to the first part of the record, simulated open loop over all of
    it, and compared in the rest. A ball screw or a belt often resists one way more than
    the other; the usual law then calls the mean of the difference an offset.

    Args:
        log: The axis's log.
        usual: The usual law's estimate from it, where the fits begin.
        gain: Force per volt [N/V].
        delay_samples: As in `estimate_drive_axis`.

    Returns:
        Both errors, and the extended law's estimate from the whole record.
    """
    kept = int(FITTED_SHARE * len(log.time))
    part = AxisLog(log.time[:kept], log.voltage[:kept], log.position[:kept], log.position_unit)
    force = gain * delayed(log.voltage, delay_samples)[:-1]

    def fitted(record: AxisLog, names: tuple[str, ...]) -> DriveAxisEstimate:
        start = np.array([[float(getattr(usual.parameters, name)) for name in names]])
        return estimate_drive_axis(
            record, gain=gain, delay_samples=delay_samples, starts=start, names=names
        )

    def ahead(names: tuple[str, ...]) -> float:
        axis, steps = fitted(part, names).parameters, jnp.diff(log.time)
        simulated = axis_positions(axis, force, steps=steps, start=log.position[0])
        return float(jnp.sqrt(jnp.mean(jnp.square(simulated - log.position)[kept:])))

    extended = fitted(log, EXTENDED_NAMES)
    return AxisLaws(ahead(PARAMETER_NAMES), ahead(EXTENDED_NAMES), extended)
