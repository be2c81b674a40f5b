"""Which friction law, and which estimator, an axis asks for: what predicts unseen data best."""

import dataclasses
import math

import numpy as np

from identification.axis.drive_axis import delayed, estimate_drive_axis
from identification.axis.estimate import EXTENDED_NAMES, PARAMETER_NAMES, DriveAxisEstimate
from identification.axis.horizons import horizons, mean_squares
from identification.axis.log import AxisLog
from identification.axis.record import SHORTEST, axis_record

FITTED_SHARE = 0.6
"""Share of the record that is fitted to, before the rest is predicted [1]."""

WORTH_IT = 0.95
"""Error of what is less usual over that of the usual up to which it is preferred [1]."""


@dataclasses.dataclass(frozen=True, eq=False)
class AxisLaws:
    """The usual law and the extended one, each fitted to a part and predicting the rest.

    Errors ahead are geometric means over the horizons, from a few samples to the open loop.
    """

    usual: DriveAxisEstimate
    """The usual law fitted to the whole record."""
    extended: DriveAxisEstimate
    """The extended law fitted to the whole record."""
    usual_ahead: float
    """Error of the usual law in the part that it wasn't fitted to [m or rad]; NaN for a record
    that is too short to hold a part out."""
    extended_ahead: float
    """The same of the extended law [m or rad]."""
    open_loop_ahead: float
    """The same of the usual law, fitted to the open loop alone [m or rad]."""

    @property
    def extended_is_preferred(self) -> bool:
        """Whether the data that were held out prefer the extended law."""
        return self.extended_ahead < WORTH_IT * self.usual_ahead

    @property
    def preferred(self) -> DriveAxisEstimate:
        """The law that the data that were held out prefer."""
        return self.extended if self.extended_is_preferred else self.usual


def axis_laws(log: AxisLog, *, gain: float, delay_samples: int = 0) -> AxisLaws:
    r"""Both friction laws of an axis, fitted by the estimator that predicts better.

    $$ M \ddot q + (F_v + \mathrm{sgn}(\dot q)\,\Delta F_v / 2)\,\dot q
       + F_c\,\mathrm{Sgn}\,\dot q + o \ni g u $$

    The laws are fitted to the first part of the record and compared in the rest, over all
    horizons. A ball screw or a belt often resists one way more than the other; the usual law
    then calls the mean of the difference an offset. The estimators are all horizons together
    and the open loop alone: the usual law is fitted by both, and the open loop alone is taken
    where it predicts better.

    Args:
        log: The axis's log.
        gain: Force per volt [N/V]; [N m/V] for a rotary axis.
        delay_samples: As in `estimate_drive_axis`.

    Returns:
        Both laws, and how well each predicts.

    Raises:
        ValueError: As of `estimate_drive_axis`.
    """
    usual = estimate_drive_axis(log, gain=gain, delay_samples=delay_samples)
    trial = _Trial(log, usual, gain, delay_samples)
    usual_ahead = trial.ahead(PARAMETER_NAMES, alone=False)
    open_loop_ahead = trial.ahead(PARAMETER_NAMES, alone=True)
    alone = open_loop_ahead < WORTH_IT * usual_ahead
    if alone:
        usual = trial.fitted(log, PARAMETER_NAMES, alone=True)
    return AxisLaws(
        usual=usual,
        extended=trial.fitted(log, EXTENDED_NAMES, alone=alone),
        usual_ahead=open_loop_ahead if alone else usual_ahead,
        extended_ahead=trial.ahead(EXTENDED_NAMES, alone=alone),
        open_loop_ahead=open_loop_ahead,
    )


@dataclasses.dataclass(frozen=True, eq=False)
class _Trial:
    """A log that laws and estimators are tried on."""

    log: AxisLog
    begun: DriveAxisEstimate
    gain: float
    delay_samples: int

    @property
    def kept(self) -> int:
        """Samples that are fitted to."""
        return int(FITTED_SHARE * len(self.log.time))

    def fitted(self, log: AxisLog, names: tuple[str, ...], *, alone: bool) -> DriveAxisEstimate:
        """A law fitted to a log, from the estimate that the whole log gave."""
        start = [float(getattr(self.begun.parameters, name)) for name in names]
        return estimate_drive_axis(
            log,
            gain=self.gain,
            delay_samples=self.delay_samples,
            starts=np.array([start]),
            names=names,
            open_loop_alone=alone,
        )

    def ahead(self, names: tuple[str, ...], *, alone: bool) -> float:
        """Error of a law in the part that it wasn't fitted to; NaN if there can't be one."""
        kept, samples = self.kept, len(self.log.time)
        if min(kept, samples - kept) < 2 * SHORTEST:
            return math.nan
        try:
            axis = self.fitted(_part(self.log, 0, kept), names, alone=alone).parameters
            rest = axis_record(_part(self.log, kept, samples))
        except ValueError:
            # A part may stand still, or hold nothing but gaps.
            return math.nan
        force = self.gain * np.asarray(delayed(self.log.voltage, self.delay_samples))[kept:]
        seen = horizons(rest, force)
        theta = np.array(
            [
                math.log(float(axis.mass)),
                *(float(getattr(axis, name)) for name in EXTENDED_NAMES[1:]),
                *np.asarray(seen.velocities).tolist(),
            ]
        )
        residuals, _ = seen.linearised(theta[None], np.full(len(seen.lengths), np.inf))
        square = mean_squares(residuals[0], count=seen.count, noise=rest.noise)
        return float(np.exp(0.5 * np.mean(np.log(square))))


def _part(log: AxisLog, start: int, end: int) -> AxisLog:
    cut = (column[start:end] for column in (log.time, log.voltage, log.position))
    return AxisLog(*cut, log.position_unit)
