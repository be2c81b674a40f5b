"""`codesign.json`: the recommended design, the front, and what stands beside them."""

import dataclasses
import json
import pathlib
from typing import Annotated, Any, Literal

import jax.numpy as jnp
import numpy as np
import pydantic

from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.numerics.files import write_whole
from scdpr_jax.numerics.json_file import JsonObject, read_json
from scdpr_jax.provenance import UNKNOWN, Provenance
from tuning.codesign.as_tuning import tuning_of
from tuning.codesign.designed import Designed
from tuning.codesign.recommendation import CoDesign
from tuning.codesign.unknowns import Law
from tuning.loop.worst_margins import WorstMargin
from tuning.result.document import tuning_document
from tuning.result.numbers_in_files import (
    Instants,
    SamplePeriod,
    Seconds,
    VoltSecondsPerRadian,
    VoltsPerRadian,
    check_impulses,
)

_Share = Annotated[float, pydantic.Field(ge=-100.0, le=100.0)]
"""Share of the way [1]; a leg that overshoots a hundredfold isn't one."""


def codesign_document(
    design: CoDesign, *, caution: str = "", provenance: Provenance = UNKNOWN
) -> str:
    """A co-design as the text of `codesign.json`.

    Args:
        design: The co-design.
        caution: What it has to warn of; empty for nothing.
        provenance: Where it comes from.

    Returns:
        JSON text; SI units.
    """
    scope, tuning = design.scope, tuning_of(design, caution=caution)
    tuning = dataclasses.replace(tuning, provenance=provenance)
    columns, rows = scope.grid
    document = {
        "format": 1,
        "provenance": provenance.model_dump(),
        **({"caution": caution} if caution else {}),
        **_designed(design.chosen),
        "margins": {
            "flexible": [_margin(margin) for margin in design.margins],
            "flexible_with_eq_25": [_margin(margin) for margin in design.margins_before],
        },
        "front": [_designed(each) for each in design.front],
        "compared": {
            name: [_figures(each) for each in designs]
            for name, designs in design.compared.items()
        },
        "held_out": {name: _figures(each) for name, each in design.held_out.items()},
        "models": {
            "columns": columns,
            "rows": rows,
            "settings": {"value": list(scope.settings), "unit": "N"},
            "samples": scope.samples,
            "seed": scope.seed,
            "count": len(np.asarray(design.chosen.measures.residual_vibration)),
        },
        # The same as `scdpr plan` and the exports take it.
        "tuning": json.loads(tuning_document(tuning)),
    }
    return json.dumps(document, indent=1, allow_nan=False) + "\n"


def write_codesign(
    path: pathlib.Path,
    design: CoDesign,
    *,
    caution: str = "",
    provenance: Provenance = UNKNOWN,
) -> None:
    """Write a co-design as `codesign.json`, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        design: The co-design.
        caution: What it has to warn of; empty for nothing.
        provenance: Where it comes from.
    """
    text = codesign_document(design, caution=caution, provenance=provenance)
    write_whole(path, text)


def read_law(path: pathlib.Path) -> Law:
    """Read the recommended design from `codesign.json`, to be run or judged anew.

    Args:
        path: The file.

    Returns:
        The design; what it comes to isn't read.

    Raises:
        ValueError: If the file isn't what `scdpr codesign` writes; says where.
    """
    document = read_json(path, _Document, expected="a codesign.json", verb="codesign")
    gains, shaper = document.controller, document.shaper
    return Law(
        PD(
            gains.proportional_gain.value,
            gains.derivative_gain.value,
            gains.period.value,
        ),
        Shaper(shaper.times.value, shaper.amplitudes),
        jnp.asarray(document.leg.bezier_control_points),
        jnp.asarray(document.leg.duration.value),
    )


def _designed(design: Designed) -> dict[str, Any]:
    law = design.law
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
        **_figures(design),
    }


def _figures(design: Designed) -> dict[str, Any]:
    measures = design.measures
    return {
        "move_time": {"value": design.move_time, "unit": "s"},
        "vibration": {
            "worst_tenth": design.vibration,
            "worst": float(np.max(measures.residual_vibration)),
            "mean": float(np.mean(measures.residual_vibration)),
            "unit": "m",
        },
        "resting_error": {
            "worst": float(np.max(measures.resting_error)),
            "mean": float(np.mean(measures.resting_error)),
            "unit": "m",
        },
        "largest_error": {"value": float(np.max(measures.largest_error)), "unit": "m"},
        "largest_voltage": {"value": float(np.max(measures.largest_voltage)), "unit": "V"},
    }


def _margin(margin: WorstMargin) -> dict[str, Any]:
    return {
        "measure": margin.measure,
        "value": margin.value if np.isfinite(margin.value) else None,
        "loop": margin.loop,
        "height": margin.height,
        "pretension": margin.pretension,
    }


class _Controller(JsonObject):
    proportional_gain: VoltsPerRadian
    derivative_gain: VoltSecondsPerRadian
    period: SamplePeriod


class _Shaper(JsonObject):
    times: Instants
    amplitudes: list[float]

    @pydantic.model_validator(mode="after")
    def _is_a_shaper(self) -> "_Shaper":
        check_impulses(self.times.value, self.amplitudes)
        return self


class _Leg(JsonObject):
    duration: Seconds
    bezier_control_points: Annotated[list[_Share], pydantic.Field(min_length=2)]


class _Document(JsonObject):
    format: Literal[1]
    controller: _Controller
    shaper: _Shaper
    leg: _Leg
