"""What was measured otherwise, beside what the fit makes of it."""

from experiments.page.number_text import plain
from identification.fit.unknowns.measured import MeasuredFit


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
