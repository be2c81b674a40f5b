"""What was measured otherwise, beside what the fit makes of it."""

from experiments.page.number_text import plain, readable_unit, rounded
from experiments.page.table import Table
from identification.result.estimate import Estimate

APART = 3.0
"""Standard errors from which the logs contradict what was measured otherwise [1]."""


def measured_tables(estimate: Estimate) -> tuple[Table, ...]:
    """What was measured otherwise, beside the fit.

    Args:
        estimate: The estimate.

    Returns:
        One table, or none where nothing was.
    """
    rows = tuple(
        (
            fit.measured.name.replace("_", " "),
            fit.measured.setting or "",
            rounded(float(fit.measured.value), float(fit.measured.sigma)),
            rounded(float(fit.measured.sigma), float(fit.measured.sigma)),
            rounded(fit.value, float(fit.measured.sigma)),
            "" if fit.measured.unit == "1" else readable_unit(fit.measured.unit),
            plain(fit.deviation, 2),
        )
        for fit in estimate.measured_fits
    )
    header = ("what", "at", "measured", "± σ", "fitted", "unit", "apart [σ]")
    title = "Measured otherwise, and what the fit makes of it"
    return (Table(title, header, rows),) if rows else ()


def contradictions(estimate: Estimate) -> tuple[str, ...]:
    """Where the logs contradict what was measured otherwise, in words.

    Args:
        estimate: The estimate.

    Returns:
        A sentence on each such number.
    """
    return tuple(
        f"The logs contradict the {fit.measured.name.replace('_', ' ')} that was measured "
        f"otherwise{' at ' + fit.measured.setting if fit.measured.setting else ''}: it is "
        f"{plain(abs(fit.deviation), 2)} of its standard errors off. The fit is a compromise "
        "between both: find out which is wrong."
        for fit in estimate.measured_fits
        if abs(fit.deviation) >= APART
    )
