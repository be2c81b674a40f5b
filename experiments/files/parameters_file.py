"""`parameters.json`: what a fit says about a robot, or about a single axis."""

import dataclasses
import json
import math
import pathlib
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
import pydantic
from jaxtyping import Float

from experiments.reports.measured_section import fitted
from identification.axis.drive_axis import DriveAxisEstimate
from identification.axis.law import AxisLaws
from identification.checks.posterior import Posterior
from identification.checks.profile import Profile
from identification.fit.unknowns.unknowns import PER_SETTING
from identification.judge.influence import Influence
from identification.judge.validation import validate
from identification.result.estimate import Estimate
from scdpr_jax.numerics.files import write_whole
from scdpr_jax.robot.parameters import EVERY_QUANTITY, Robot, exact, replace
from scdpr_jax.robot.prototype import consistent
from tuning.result.json_file import read_json

AXIS_UNITS = {
    "mass": "kg",
    "viscous": "N s/m",
    "coulomb": "N",
    "offset": "N",
    "viscous_difference": "N s/m",
}
"""SI units of a linear axis's parameters."""


def write_parameters(
    path: pathlib.Path,
    estimate: Estimate,
    profiles: Sequence[Profile] = (),
    posterior: Posterior | None = None,
) -> None:
    """Write an estimate as `parameters.json`, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        estimate: The estimate.
        profiles: Its profiles, where they were traced.
        posterior: Draws from what the logs leave possible, where they were made.
    """
    fit = estimate.fit
    document = {
        "format": 1,
        "parameters": [
            {
                "name": parameter.name,
                "setting": parameter.setting,
                "value": parameter.value,
                "unit": parameter.unit,
                "sigma": _finite(parameter.sigma),
                "interval95": [_finite(end) for end in parameter.interval95],
                "status": parameter.status,
            }
            for parameter in estimate.parameters
        ],
        "correlation": {
            "names": [
                parameter.name
                if parameter.setting is None
                else f"{parameter.name} {parameter.setting}"
                for parameter in estimate.parameters
                if parameter.status != "fixed"
            ],
            "matrix": estimate.correlation.tolist(),
        },
        "runs": [
            {
                "name": run.name,
                "kind": run.kind,
                "fitted": not run.held_out,
                **_circumstances(estimate, run.name),
            }
            for run in estimate.comparisons
        ],
        "residuals": [
            {
                "run": run.name,
                "channel": channel.name,
                "unit": channel.unit,
                "rms": channel.rms,
                "noise_sigma": channel.sigma,
                "chi_square": channel.chi_square,
                "is_noise": channel.is_noise,
                "worst_at_s": channel.worst_time,
                "fit": _finite(left.fit),
                "whiteness_p": _finite(left.whiteness),
                "independence_p": _finite(left.independence),
                "verdict": left.verdict,
            }
            for run in estimate.comparisons
            for channel, left in zip(run.channels, validate(run), strict=True)
        ],
        "profiles": [
            {
                "name": one.name,
                "setting": one.setting,
                "label": one.label,
                "interval95": [_finite(end) for end in one.ends],
                "values": one.values.tolist(),
                "misfit_rise": one.rise.tolist(),
                "threshold": one.threshold,
            }
            for one in profiles
        ],
        "posterior": [] if posterior is None else _posterior(posterior),
        "measured_otherwise": [
            {
                "name": one.name,
                "setting": one.setting,
                "value": float(one.value),
                "sigma": float(one.sigma),
                "unit": one.unit,
                "fitted": value,
            }
            for one, value, _ in fitted(estimate)
        ],
        "models": [
            dataclasses.asdict(model) | {"chosen": number == estimate.choice}
            for number, model in enumerate(estimate.models)
        ],
        "fit": {
            "ended": fit.ended,
            "iterations": fit.iterations,
            "misfit": fit.misfit,
            "measurements": fit.measurements,
            "starts": list(fit.starts),
            "minima": [valley._asdict() for valley in fit.valleys],
            "influence": _influence(estimate.influence),
        },
    }
    write_whole(path, json.dumps(document, indent=1, allow_nan=False) + "\n")


def _circumstances(estimate: Estimate, run: str) -> dict[str, float | None]:
    """What was estimated of a run by itself; null for one without the cable."""
    own = estimate.circumstances.get(run)
    names = {
        "clock_offset_s": "clock_offset",
        "clock_drift": "clock_drift",
        "knock_N": "knock",
        "knock_arm_m": "knock_arm",
    }
    return {key: None if own is None else float(getattr(own, of)) for key, of in names.items()}


def _posterior(drawn: Posterior) -> list[dict[str, Any]]:
    mean, sigma, interval = drawn.mean, drawn.sigma, drawn.interval()
    return [
        {
            "name": name,
            "setting": setting,
            "mean": float(mean[k]),
            "sigma": float(sigma[k]),
            "interval95": interval[k].tolist(),
            "r_hat": float(drawn.r_hat[k]),
            "effective_draws": float(drawn.effective[k]),
        }
        for k, (name, setting) in enumerate(drawn.names)
    ]


def _influence(found: Influence) -> dict[str, Any]:
    """What leaving out each run does, and the bootstrap over runs."""

    def rows(table: Float[np.ndarray, "runs quantities"]) -> list[list[float | None]]:
        return [[_finite(float(number)) for number in row] for row in table]

    return {
        "quantities": [{"name": name, "setting": setting} for name, setting in found.names],
        "runs": list(found.runs),
        "refitted": found.refitted,
        "value_without_run": rows(found.without),
        "moved_standard_errors": rows(found.moved),
        "moved_by_noise_standard_errors": rows(found.by_noise),
        "bootstrap": {
            "interval95": [own and list(own) for own in found.interval95],
            "runs_that_tell": found.telling.tolist(),
            "resamples": found.resamples,
            "seed": found.seed,
        },
    }


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
                "sigma": _finite(float(getattr(estimate.sigma, name))),
                "interval95": [_finite(float(end)) for end in estimate.interval95[row]],
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


class Parameter(pydantic.BaseModel):
    """A row of `parameters.json`, as far as a robot is built from it."""

    name: str
    setting: str | None
    value: pydantic.FiniteFloat
    unit: str
    sigma: pydantic.FiniteFloat | None = None
    status: Literal["identified", "weak", "unidentifiable", "at_bound", "fixed"]


class _Correlation(pydantic.BaseModel):
    """How the fitted parameters' errors hang together."""

    names: list[str]
    matrix: list[list[pydantic.FiniteFloat]]


class Residual(pydantic.BaseModel):
    """What a fit leaves of a channel of a run."""

    channel: str
    rms: pydantic.FiniteFloat
    noise_sigma: pydantic.FiniteFloat
    is_noise: bool


class FittedRobot(pydantic.BaseModel):
    """A robot from `parameters.json`."""

    format: Literal[1]
    parameters: list[Parameter]
    correlation: _Correlation | None = None
    residuals: list[Residual] = []

    @property
    def robot(self) -> Robot:
        """The robot at its first pretension setting."""
        known = {quantity.name for quantity in EVERY_QUANTITY}
        values: dict[str, float] = {}
        for row in self.parameters:
            if row.name in known:
                values.setdefault(row.name, row.value)
        return exact(replace(consistent(), values))

    @property
    def settings(self) -> tuple[str, ...]:
        """The nominal pretensions that have an effective one."""
        return tuple(
            row.setting for row in self.parameters if row.name == PER_SETTING and row.setting
        )

    def of_setting(self, label: str) -> Robot:
        """The robot at a nominal pretension.

        Args:
            label: The setting, "350 N".

        Returns:
            The robot with its effective pretension.

        Raises:
            ValueError: If the file has no such setting.
        """
        for row in self.parameters:
            if row.name == PER_SETTING and row.setting in (label, None):
                return replace(self.robot, {PER_SETTING: row.value})
        known = ", ".join(self.settings) or "none"
        raise ValueError(
            f"`setting`: no effective pretension for {label!r}, got {known} in the parameters "
            "[N]. Name one of these, or identify from runs at that setting."
        )


def read_parameters(path: pathlib.Path) -> FittedRobot:
    """Read a robot from `parameters.json`.

    Args:
        path: The file.

    Returns:
        The robot, with exact friction.

    Raises:
        ValueError: If the file isn't what `scdpr identify` writes; says where.
    """
    found = read_json(path, FittedRobot, expected="a parameters.json", verb="identify")
    units = {quantity.name: quantity.unit for quantity in EVERY_QUANTITY}
    for row in found.parameters:
        if row.name in units and row.unit != units[row.name]:
            raise ValueError(
                f"{path}: the unit of {row.name!r} is wrong, got {row.unit!r}, expected "
                f"{units[row.name]!r}. Give the value in SI units."
            )
    return found


def _finite(number: float) -> Any:
    """A number that JSON can hold; null for one that isn't finite."""
    return number if math.isfinite(number) else None
