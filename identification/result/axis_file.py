"""`parameters.json` of a single drive axis."""

import json
import pathlib
from typing import Any

from identification.axis.drive_axis import DriveAxisEstimate
from identification.axis.law import AxisLaws
from identification.result.parameters_file import finite
from scdpr_jax.numerics.files import write_whole

AXIS_UNITS = {
    "mass": "kg",
    "viscous": "N s/m",
    "coulomb": "N",
    "offset": "N",
    "viscous_difference": "N s/m",
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
    write_whole(path, json.dumps(document, indent=1, allow_nan=False) + "\n")


def _axis(estimate: DriveAxisEstimate) -> dict[str, Any]:
    return {
        "parameters": [
            {
                "name": name,
                "setting": None,
                "value": float(getattr(estimate.parameters, name)),
                "unit": AXIS_UNITS[name],
                "sigma": finite(float(getattr(estimate.sigma, name))),
                "interval95": [finite(float(end)) for end in estimate.interval95[row]],
                "status": estimate.status[row],
            }
            for row, name in enumerate(estimate.names)
        ],
        "correlation": {
            "names": list(estimate.names),
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
