"""`tuning.json`: gains, shapers and what they are predicted to do."""

import dataclasses
import json
import math
import pathlib
from typing import Any, Literal

import jax.numpy as jnp
import pydantic
import pydantic_core

from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.numerics.files import write_whole
from scdpr_jax.numerics.files.given import RESULT, read_given
from scdpr_jax.numerics.json_file import JsonObject, read_json
from scdpr_jax.provenance import UNKNOWN, Provenance
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import EVERY_QUANTITY, QUANTITIES, quantity, replace
from scdpr_jax.robot.stated.ranges import check_robot
from tuning.loop.margins import Margins
from tuning.loop.worst_margins import WorstMargin
from tuning.result.legs_in_files import LegsInFile, legs_document
from tuning.result.numbers_in_files import (
    Newtons,
    SamplePeriod,
    Seconds,
    Span,
    Time,
    VoltSecondsPerRadian,
    VoltsPerRadian,
    check_impulses,
)
from tuning.result.prediction import Metrics, Prediction
from tuning.result.regional_shaper import Region, RegionalShaper, ResidualVibration
from tuning.result.tuning import FittedSetting, Tuning


def tuning_document(tuning: Tuning) -> str:
    """A tuning as the text of `tuning.json`.

    A number that isn't finite, such as the gain margin of a loop that has no phase
    crossover, is null. Traces of the predicted runs aren't written.

    Args:
        tuning: The tuning.

    Returns:
        JSON text.
    """
    controller = tuning.controller
    document = {
        "format": 1,
        "provenance": tuning.provenance.model_dump(),
        "controller": {
            "proportional_gain": {
                "value": float(controller.proportional_gain),
                "unit": "V/rad",
            },
            "derivative_gain": {
                "value": float(controller.derivative_gain),
                "unit": "V s/rad",
            },
            "period": {"value": float(controller.period), "unit": "s"},
            "filter_time": {"value": float(controller.filter_time), "unit": "s"},
            "margins": {
                field.name: _finite(float(getattr(tuning.margins, field.name)))
                for field in dataclasses.fields(Margins)
            }
            | {"flexible": [_worst(margin) for margin in tuning.worst_margins]},
        },
        "shapers": [_shaper(regional) for regional in tuning.shapers],
        "robots": [_robot(fitted) for fitted in tuning.robots],
        "predicted": {
            prediction.name: {
                "before": dataclasses.asdict(prediction.before),
                "after": dataclasses.asdict(prediction.after),
            }
            for prediction in tuning.predicted
        },
        "legs": None if tuning.legs is None else legs_document(tuning.legs),
        "notes": list(tuning.notes),
    }
    if tuning.caution:
        document = {"format": 1, "caution": tuning.caution} | document
    return json.dumps(document, indent=1, allow_nan=False) + "\n"


def write_tuning(path: pathlib.Path, tuning: Tuning) -> None:
    """Write a tuning as `tuning.json`, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        tuning: The tuning.
    """
    write_whole(path, tuning_document(tuning))


def read_tuning(path: pathlib.Path) -> Tuning:
    """Read a tuning from `tuning.json`, or the one that is in a `codesign.json`.

    Args:
        path: The file.

    Returns:
        The tuning, its predictions without traces.

    Raises:
        ValueError: If the file isn't what `scdpr tune` writes; says where.
    """
    document = _read(path)
    gains = document.controller
    return Tuning(
        controller=PD(
            gains.proportional_gain.value,
            gains.derivative_gain.value,
            gains.period.value,
            gains.filter_time.value,
        ),
        margins=Margins(
            **{
                name: jnp.asarray(_unbounded(name) if number is None else number)
                for name, number in gains.margins.model_dump(exclude={"flexible"}).items()
            }
        ),
        shapers=tuple(shaper.build() for shaper in document.shapers),
        predicted=tuple(
            Prediction(name, Metrics(**pair.before), Metrics(**pair.after))
            for name, pair in document.predicted.items()
        ),
        robots=tuple(fitted.build() for fitted in document.robots),
        worst_margins=tuple(
            WorstMargin(**{**worst.model_dump(), "value": _told(worst)})
            for worst in gains.margins.flexible
        ),
        notes=document.notes,
        legs=None if document.legs is None else document.legs.build(),
        caution=document.caution,
        provenance=document.provenance,
    )


def _read(path: pathlib.Path) -> "_Document":
    """The document, by itself or within a co-design's."""
    try:
        content = pydantic_core.from_json(read_given(pathlib.Path(path), most=RESULT))
    except (OSError, ValueError):
        content = None  # What is wrong with it is told below.
    if isinstance(content, dict) and {"front", "leg"} <= content.keys():
        return read_json(path, _CoDesign, expected="a codesign.json", verb="codesign").tuning
    return read_json(path, _Document, expected="a tuning.json", verb="tune")


def _shaper(regional: RegionalShaper) -> dict[str, Any]:
    region, shaper = regional.region, regional.shaper
    return {
        "region": {
            "x": list(region.x),
            "y": list(region.y),
            "pretension": list(region.pretension),
        },
        "height": regional.height,
        "times": shaper.times.tolist(),
        "amplitudes": shaper.amplitudes.tolist(),
        "duration": float(shaper.duration),
        "residual_vibration": dataclasses.asdict(regional.residual_vibration),
        "frequency": regional.frequency,
        "band": list(regional.band),
        "damping_ratio": regional.damping_ratio,
        "measured": regional.measured,
        "kind": regional.kind,
        "share": regional.share,
    }


def _robot(fitted: FittedSetting) -> dict[str, Any]:
    return {
        "pretension": {"value": fitted.pretension, "unit": "N"},
        "parameters": {
            named.name: {"value": float(named.leaves(fitted.robot)[0]), "unit": named.unit}
            for named in EVERY_QUANTITY
        },
    }


def _worst(margin: WorstMargin) -> dict[str, Any]:
    return dataclasses.asdict(margin) | {"value": _finite(margin.value)}


def _told(worst: "_WorstMargin") -> float:
    return _unbounded(worst.measure) if worst.value is None else worst.value


def _finite(number: float) -> float | None:
    return number if math.isfinite(number) else None


def _unbounded(name: str) -> float:
    """What null stands for: a margin without bound, a crossover that isn't there."""
    return math.inf if name == "gain_margin" else math.nan


class _WorstMargin(JsonObject):
    measure: str
    value: float | None
    loop: str
    height: float
    pretension: float


class _Margins(JsonObject):
    gain_crossover: float | None
    phase_margin: float | None
    delay_margin: float | None
    phase_crossover: float | None
    gain_margin: float | None
    peak_sensitivity: float | None
    flexible: tuple[_WorstMargin, ...] = ()


class _Controller(JsonObject):
    proportional_gain: VoltsPerRadian
    derivative_gain: VoltSecondsPerRadian
    period: SamplePeriod = SamplePeriod(value=1e-3, unit="s")
    filter_time: Seconds = Seconds(value=0.0, unit="s")
    margins: _Margins


class _Region(JsonObject):
    x: Span
    y: Span
    pretension: Span


class _Residual(JsonObject):
    nominal: pydantic.NonNegativeFloat
    worst: pydantic.NonNegativeFloat


class _Shaper(JsonObject):
    region: _Region
    height: float | None = None
    times: list[Time]
    amplitudes: list[float]
    residual_vibration: _Residual
    frequency: pydantic.PositiveFloat
    band: Span
    damping_ratio: pydantic.NonNegativeFloat
    measured: bool
    kind: str = ""
    share: pydantic.NonNegativeFloat | None = None

    @pydantic.model_validator(mode="after")
    def _is_a_shaper(self) -> "_Shaper":
        check_impulses(self.times, self.amplitudes)
        return self

    def build(self) -> RegionalShaper:
        # Files from before heights were written tell the region only.
        height = sum(self.region.y) / 2 if self.height is None else self.height
        return RegionalShaper(
            region=Region(self.region.x, self.region.y, self.region.pretension),
            height=height,
            shaper=Shaper(self.times, self.amplitudes),
            frequency=self.frequency,
            band=self.band,
            damping_ratio=self.damping_ratio,
            measured=self.measured,
            residual_vibration=ResidualVibration(**self.residual_vibration.model_dump()),
            kind=self.kind,
            share=self.share,
        )


class _Number(JsonObject):
    value: float
    unit: str


class _Robot(JsonObject):
    pretension: Newtons
    parameters: dict[str, _Number]

    @pydantic.model_validator(mode="after")
    def _has_every_quantity(self) -> "_Robot":
        missing = {named.name for named in QUANTITIES} - self.parameters.keys()
        if missing:
            raise ValueError(f"without {sorted(missing)}, expected every quantity of the robot")
        for name, number in self.parameters.items():
            unit = quantity(name).unit
            if number.unit != unit:
                raise ValueError(f"the unit of {name}: got {number.unit!r}, expected {unit!r}")
        check_robot({name: number.value for name, number in self.parameters.items()})
        return self

    def build(self) -> FittedSetting:
        values = {name: number.value for name, number in self.parameters.items()}
        return FittedSetting(self.pretension.value, exact(replace(consistent(), values)))


class _Pair(JsonObject):
    before: dict[str, float]
    after: dict[str, float]

    @pydantic.model_validator(mode="after")
    def _has_every_metric(self) -> "_Pair":
        metrics = {field.name for field in dataclasses.fields(Metrics)}
        for side in (self.before, self.after):
            if set(side) != metrics:
                raise ValueError(f"got {sorted(side)}, expected the metrics {sorted(metrics)}")
        return self


class _Document(JsonObject):
    format: Literal[1]
    controller: _Controller
    shapers: list[_Shaper]
    predicted: dict[str, _Pair]
    robots: tuple[_Robot, ...] = ()
    legs: LegsInFile | None = None
    notes: tuple[str, ...] = ()
    caution: str = ""
    provenance: Provenance = UNKNOWN


class _CoDesign(JsonObject):
    """`codesign.json`, as far as it is a tuning."""

    format: Literal[1]
    tuning: _Document
