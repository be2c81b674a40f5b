"""What rows of `parameters.json` can't say of a robot.

A value is taken from the file into every prediction, so one that is missing, of another unit
or of no robot at all mustn't be filled up in silence.
"""

from collections.abc import Sequence

from identification.judge.uncertainty import ParameterEstimate
from scdpr_jax.robot.quantities import EVERY_QUANTITY, QUANTITIES
from scdpr_jax.robot.stated.ranges import check_robot, check_value


def check_parameters(parameters: Sequence[ParameterEstimate]) -> None:
    """Refuse parameters that no fit of a robot gives.

    Args:
        parameters: The rows; those of unknown names say nothing of the robot.

    Raises:
        ValueError: If a quantity is missing or there twice, a value is none of a robot's, a
            standard error is negative, or an interval ends before it begins. One message:
            what, got, expected and what to do.
    """
    names = {quantity.name for quantity in EVERY_QUANTITY}
    rows = [row for row in parameters if row.name in names]
    _check_names(rows)
    for row in rows:
        check_value(row.name, row.value)
        _check_errors(row)
    first = {row.name: row.value for row in reversed(rows)}
    check_robot(first)


def _check_names(rows: Sequence[ParameterEstimate]) -> None:
    missing = sorted({kind.name for kind in QUANTITIES} - {row.name for row in rows})
    if missing:
        some = ", ".join(missing[:3]) + (" and others" if len(missing) > 3 else "")
        raise ValueError(
            f"parameters are missing, got {len(rows)} rows without {some}, "
            "expected a row for every quantity of the robot. Write the file anew with `scdpr "
            "identify`; a name that is misspelt counts as missing."
        )
    labels = [row.label for row in rows]
    twice = sorted({label for label in labels if labels.count(label) > 1})
    if twice:
        raise ValueError(
            f"parameters are there twice, got {', '.join(twice)}, expected one row for each "
            "quantity and setting. Delete the row that doesn't hold."
        )


def _check_errors(row: ParameterEstimate) -> None:
    low, high = row.interval95
    if not (row.sigma >= 0 and low <= high):
        raise ValueError(
            f"the errors of `{row.label}` can't be, got sigma {row.sigma:g} and an interval "
            f"from {low:g} to {high:g} [{row.unit}], expected a standard error that isn't "
            "negative and an interval in order. Write the file anew with `scdpr identify`."
        )
