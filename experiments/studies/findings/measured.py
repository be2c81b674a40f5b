"""What was measured otherwise, beside what the fit makes of it."""

import dataclasses

from experiments.page.number_text import plain
from identification.fit.unknowns.measured import Measured, deviation
from identification.result.estimate import Estimate

APART = 3.0
"""Standard errors from which the logs contradict what was measured otherwise [1]."""


@dataclasses.dataclass(frozen=True)
class MeasuredFit:
    """A number that was measured otherwise, and the fit's own."""

    measured: Measured
    """What was measured."""
    value: float
    """The fitted robot's [SI]."""
    deviation: float
    """Fitted minus measured, in the measurement's standard errors [1]."""

    @property
    def is_contradicted(self) -> bool:
        """Whether the logs contradict it."""
        return abs(self.deviation) >= APART


def measured_fits(estimate: Estimate) -> tuple[MeasuredFit, ...]:
    """What the fit makes of each number that was measured otherwise.

    Args:
        estimate: The estimate.

    Returns:
        The numbers, in the order in which they were given.
    """
    fits = []
    for number in estimate.measured:
        robot = estimate.of_setting(number.setting) if number.setting else estimate.robot
        fits.append(MeasuredFit(number, float(number.of(robot)), deviation(number, robot)))
    return tuple(fits)


def contradiction_sentence(fit: MeasuredFit) -> str:
    """That the logs contradict what was measured otherwise, in words.

    Args:
        fit: The number, and the fit's own.

    Returns:
        The sentence.
    """
    number = fit.measured
    return (
        f"The logs contradict the {number.name.replace('_', ' ')} that was measured otherwise"
        f"{' at ' + number.setting if number.setting else ''}: it is "
        f"{plain(abs(fit.deviation), 2)} of its standard errors off. The fit is a compromise "
        "between both: find out which is wrong."
    )
