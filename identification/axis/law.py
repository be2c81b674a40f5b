"""Which friction law an axis asks for: the usual one, or one that minds the direction."""

import dataclasses

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from identification.axis.drive_axis import (
    EXTENDED_NAMES,
    PARAMETER_NAMES,
    DriveAxisEstimate,
    delayed,
    estimate_drive_axis,
)
from identification.axis.log import AxisLog
from identification.axis.motion import AxisParameters, axis_positions

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

    def ahead(names: tuple[str, ...]) -> float:
        fitted = estimate_drive_axis(
            part,
            gain=gain,
            delay_samples=delay_samples,
            starts=_start(usual, names),
            names=names,
        )
        return _error(fitted.parameters, log, force, slice(kept, None))

    extended = estimate_drive_axis(
        log,
        gain=gain,
        delay_samples=delay_samples,
        starts=_start(usual, EXTENDED_NAMES),
        names=EXTENDED_NAMES,
    )
    return AxisLaws(ahead(PARAMETER_NAMES), ahead(EXTENDED_NAMES), extended)


def _start(usual: DriveAxisEstimate, names: tuple[str, ...]) -> Float[np.ndarray, "1 n"]:
    return np.array([[float(getattr(usual.parameters, name)) for name in names]])


def _error(
    parameters: AxisParameters, log: AxisLog, force: Float[Array, " steps"], rows: slice
) -> float:
    """Open-loop error of some rows of a log, simulated from its first sample at rest [m]."""
    simulated = axis_positions(
        parameters, force, steps=jnp.diff(log.time), start=log.position[0]
    )
    return float(jnp.sqrt(jnp.mean(jnp.square(simulated - log.position)[rows])))
