"""`parameters.json` of a single drive axis."""

import dataclasses
import pathlib
from typing import Any

from identification.axis.drive_axis import DriveAxisEstimate
from identification.axis.law import AxisLaws
from identification.axis.motion import AxisParameters
from identification.result.parameters_file import write_document

AXIS_UNITS = {
    field.name: field.metadata["unit"] for field in dataclasses.fields(AxisParameters)
}
"""SI units of a linear axis's parameters."""


def write_axis_parameters(
    path: pathlib.Path, estimate: DriveAxisEstimate, laws: AxisLaws
) -> None:
    """Write a drive axis's estimate as `parameters.json`, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        estimate: The estimate.
        laws: The extended friction law beside the usual one.
    """
    document = {
        "format": 1,
        **_axis(estimate),
        "extended": {
            "preferred_by_held_out_data": laws.extended_is_preferred,
            "held_out_rmse_m": laws.extended_ahead,
            "held_out_rmse_of_the_usual_law_m": laws.usual_ahead,
            **_axis(laws.extended),
        },
    }
    write_document(path, document)


def _axis(estimate: DriveAxisEstimate) -> dict[str, Any]:
    return {
        "parameters": [
            {
                "name": name,
                "setting": None,
                "value": float(getattr(estimate.parameters, name)),
                "unit": AXIS_UNITS[name],
                "sigma": float(getattr(estimate.sigma, name)),
                "interval95": estimate.interval95[row].tolist(),
                "status": estimate.status[row],
            }
            for row, name in enumerate(estimate.names)
        ],
        "correlation": {
            "names": estimate.names,
            "matrix": estimate.correlation.tolist(),
        },
        "open_loop_rmse_m": float(estimate.open_loop_rmse),
        "fit": {
            "converged": estimate.converged,
            "iterations": estimate.iterations,
            "starts": estimate.starts,
            "agreeing_starts": estimate.agreeing_starts,
            "residuals_hang_together_for_s": float(estimate.memory),
        },
    }
