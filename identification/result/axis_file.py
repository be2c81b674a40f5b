"""`parameters.json` of a single drive axis."""

import pathlib
from typing import Any

from identification.axis.estimate import DriveAxisEstimate
from identification.axis.law import AxisLaws
from identification.result.parameters_file import write_document
from scdpr_jax.provenance import UNKNOWN, Provenance


def write_axis_parameters(
    path: pathlib.Path, laws: AxisLaws, *, provenance: Provenance = UNKNOWN
) -> None:
    """Write a drive axis's estimate as `parameters.json`, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        laws: The usual friction law, and the extended one beside it.
        provenance: Where it comes from.
    """
    unit = laws.usual.position_unit
    document = {
        "format": 1,
        "provenance": provenance.model_dump(),
        **_axis(laws.usual),
        "extended": {
            "preferred_by_held_out_data": laws.extended_is_preferred,
            f"held_out_rmse_{unit}": laws.extended_ahead,
            f"held_out_rmse_of_the_usual_law_{unit}": laws.usual_ahead,
            f"held_out_rmse_of_the_open_loop_alone_{unit}": laws.open_loop_ahead,
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
                "unit": estimate.units[name],
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
        f"open_loop_rmse_{estimate.position_unit}": float(estimate.open_loop_rmse),
        "fits": estimate.fits,
        "not_told": [each.text() for each in estimate.untold],
        "halves_disagree": [
            {"name": change.name, "first": change.first, "second": change.second}
            for change in estimate.changes
        ],
        "notes": estimate.notes,
        "fit": {
            "converged": estimate.converged,
            "iterations": estimate.iterations,
            "starts": estimate.starts,
            "agreeing_starts": estimate.agreeing_starts,
            "residuals_hang_together_for_s": float(estimate.memory),
            "horizons_beside_the_open_loop_s": estimate.horizons,
        },
    }
