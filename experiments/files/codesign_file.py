"""`codesign.json`: the recommended design, the front, and what stands beside them."""

import json
from typing import Any

import numpy as np

from experiments.studies.codesign_run import CoDesign
from tuning.codesign import Designed
from tuning.loop.worst_margins import WorstMargin


def codesign_document(found: CoDesign) -> str:
    """A co-design as the text of `codesign.json`.

    Args:
        found: The co-design.

    Returns:
        JSON text; SI units.
    """
    asked = found.asked
    columns, rows = asked.grid
    document = {
        "format": 1,
        **_designed(found.chosen),
        "margins": {
            "flexible": [_margin(one) for one in found.margins],
            "flexible_with_eq_25": [_margin(one) for one in found.margins_before],
        },
        "front": [_designed(one) for one in found.front],
        "compared": {
            name: [_figures(one) for one in each] for name, each in found.compared.items()
        },
        "held_out": {name: _figures(one) for name, one in found.held_out.items()},
        "models": {
            "columns": columns,
            "rows": rows,
            "settings": {"value": list(asked.settings), "unit": "N"},
            "samples": asked.samples,
            "seed": asked.seed,
            "count": len(np.asarray(found.chosen.found.vibration)),
        },
    }
    return json.dumps(document, indent=1, allow_nan=False) + "\n"


def _designed(one: Designed) -> dict[str, Any]:
    law = one.law
    return {
        "controller": {
            "proportional_gain": {
                "value": float(law.controller.proportional_gain),
                "unit": "V/rad",
            },
            "derivative_gain": {
                "value": float(law.controller.derivative_gain),
                "unit": "V s/rad",
            },
            "period": {"value": 1e-3, "unit": "s"},
        },
        "shaper": {
            "times": {"value": np.asarray(law.shaper.times).tolist(), "unit": "s"},
            "amplitudes": np.asarray(law.shaper.amplitudes).tolist(),
        },
        "leg": {
            "duration": {"value": float(law.leg_time), "unit": "s"},
            "bezier_control_points": np.asarray(law.profile).tolist(),
        },
        **_figures(one),
    }


def _figures(one: Designed) -> dict[str, Any]:
    found = one.found
    return {
        "move_time": {"value": one.move_time, "unit": "s"},
        "vibration": {
            "worst_tenth": one.vibration,
            "worst": float(np.max(found.vibration)),
            "mean": float(np.mean(found.vibration)),
            "unit": "m",
        },
        "resting_error": {
            "worst": float(np.max(found.resting_error)),
            "mean": float(np.mean(found.resting_error)),
            "unit": "m",
        },
        "largest_error": {"value": float(np.max(found.largest_error)), "unit": "m"},
        "largest_voltage": {"value": float(np.max(found.largest_voltage)), "unit": "V"},
    }


def _margin(one: WorstMargin) -> dict[str, Any]:
    return {
        "measure": one.measure,
        "value": one.value if np.isfinite(one.value) else None,
        "loop": one.loop,
        "height": one.height,
        "pretension": one.pretension,
    }
