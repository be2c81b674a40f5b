"""`shaper.json`: the shaper for a spectrum beside every other that was looked at."""

import json
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from scdpr_jax.command.shaper import Shaper
from scdpr_jax.provenance import UNKNOWN, Provenance
from tuning.shapers.design import Design
from tuning.shapers.measures import smoothing
from tuning.shapers.spectrum import THRESHOLD
from tuning.shapers.spectrum_design import Compared, SpectrumDesign
from tuning.shapers.spectrum_file import SpectrumFile

ACCELERATION = 5.0
"""Acceleration that smoothing is given for [m/s²]."""
OPTIMISED = "optimised"
"""Kind of a shaper that isn't the catalogue's."""


def shaper_document(
    file: SpectrumFile,
    design: SpectrumDesign,
    *,
    firmware: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
    provenance: Provenance = UNKNOWN,
) -> str:
    """A design as the text of `shaper.json`.

    Args:
        file: The spectrum as it was read.
        design: The shapers for it.
        firmware: What a firmware is told, by its name.
        provenance: Where it comes from.

    Returns:
        JSON text; times in s, residual vibration as a share, smoothing in m.
    """
    document = {
        "format": 1,
        "provenance": provenance.model_dump(),
        **_designed(design.recommended),
        "spectrum": {
            "file": file.path.name,
            "column": file.column,
            "was_normalised": file.was_normalised,
            "peak": {"value": file.spectrum.peak, "unit": "Hz"},
            "sensors": [
                {"column": column, "peak": {"value": peak, "unit": "Hz"}}
                for column, peak in zip(file.columns, file.spectrum.peaks, strict=True)
            ],
            "notes": list(file.notes),
            "threshold": THRESHOLD,
            "damping_ratios": list(design.damping_ratios),
        },
        "design_damping_ratio": design.damping_ratio,
        "picked_from_catalogue": design.picked.entry.name,
        "compared": {
            comparison.fit.entry.name: _compared(comparison) for comparison in design.compared
        },
        "front": [_designed(each) for each in design.front],
        "firmware": dict(firmware),
    }
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def _compared(comparison: Compared) -> dict[str, Any]:
    fit = comparison.fit
    return {
        **_impulses(fit.shaper, fit.residual, fit.entry.name),
        "frequency": {"value": fit.frequency, "unit": "Hz"},
        "optimised_of_same_duration": _designed(comparison.same_duration),
        "optimised_of_same_vibration": _designed(comparison.same_vibration),
    }


def _designed(design: Design) -> dict[str, Any]:
    return {
        **_impulses(design.shaper, design.residual, OPTIMISED),
        "lower_bound": design.lower_bound,
    }


def _impulses(shaper: Shaper, residual: float, kind: str) -> dict[str, Any]:
    return {
        "kind": kind,
        "times": np.asarray(shaper.times).tolist(),
        "amplitudes": np.asarray(shaper.amplitudes).tolist(),
        "duration": float(shaper.duration),
        "residual_vibration": residual,
        "smoothing": {
            "value": float(smoothing(shaper, acceleration=ACCELERATION)),
            "unit": "m",
            "acceleration": {"value": ACCELERATION, "unit": "m/s^2"},
        },
    }
