"""`parameters.json`: what a fit says about a robot, written and read.

The file is for people and for other programs, so its format is pinned: numbers are SI, and
what isn't finite is null. Reading gives the robot with its errors back, and not the runs.
"""

import dataclasses
import json
import math
import pathlib
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from identification.data.circumstances import BEGINNING, TURNING_DRIVES, Circumstances
from identification.fit.comparison import Channel, Comparison
from identification.judge.influence import Influence
from identification.judge.likelihood import Posterior, Profile
from identification.judge.uncertainty import ParameterEstimate
from identification.judge.validation import ChannelValidation, validate
from identification.result.estimate import Estimate
from identification.result.fitted_robot import FittedRobot, Residual
from identification.result.possible_parameters import check_parameters
from scdpr_jax.numerics.files import write_whole
from scdpr_jax.numerics.json_file import JsonObject, read_json
from scdpr_jax.provenance import UNKNOWN, Provenance
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import EVERY_QUANTITY, replace


def write_parameters(
    path: pathlib.Path,
    estimate: Estimate,
    profiles: Sequence[Profile] = (),
    posterior: Posterior | None = None,
    accepted: Sequence[str] = (),
    provenance: Provenance | None = None,
) -> None:
    """Write an estimate as `parameters.json`, whole or not at all.

    Args:
        path: The file, replaced if it exists.
        estimate: The estimate.
        profiles: Its profiles, where they were traced.
        posterior: Draws from what the logs leave possible, where they were made.
        accepted: Contradictions of the sensors that the fit went on with, in words.
        provenance: Where it comes from.
    """
    write_whole(path, parameters_text(estimate, profiles, posterior, accepted, provenance))


def parameters_text(
    estimate: Estimate,
    profiles: Sequence[Profile] = (),
    posterior: Posterior | None = None,
    accepted: Sequence[str] = (),
    provenance: Provenance | None = None,
) -> str:
    """What `parameters.json` holds of an estimate.

    Args:
        estimate: The estimate.
        profiles: Its profiles, where they were traced.
        posterior: Draws from what the logs leave possible, where they were made.
        accepted: Contradictions of the sensors that the fit went on with, in words.
        provenance: Where it comes from.

    Returns:
        The text.
    """
    document = {
        "format": 1,
        **({} if provenance is None else {"provenance": provenance.model_dump()}),
        "parameters": [_parameter(p) for p in estimate.parameters],
        "correlation": {
            "names": [p.label for p in estimate.fitted.estimated],
            "matrix": estimate.correlation,
        },
        "runs": [_run(estimate, run) for run in estimate.comparisons],
        "residuals": [
            _residual(run.name, channel, validation)
            for run in estimate.comparisons
            for channel, validation in zip(run.channels, validate(run), strict=True)
        ],
        "accepted": list(accepted),
        "fits": estimate.fits,
        "unexplained": [dataclasses.asdict(channel) for channel in estimate.unexplained],
        "profiles": [_profile(profile) for profile in profiles],
        "posterior": [] if posterior is None else _posterior(posterior),
        "measured_otherwise": _measured(estimate),
        "models": [
            dataclasses.asdict(model) | {"chosen": number == estimate.choice}
            for number, model in enumerate(estimate.models)
        ],
        "fit": _fit(estimate),
    }
    return _text(document)


def write_document(path: pathlib.Path, document: dict[str, Any]) -> None:
    """Write a file of numbers whole or not at all; null for one that isn't finite.

    Args:
        path: The file, replaced if it exists.
        document: Its content; arrays become lists.
    """
    write_whole(path, _text(document))


def _text(document: dict[str, Any]) -> str:
    return json.dumps(_plain(document), indent=1, allow_nan=False) + "\n"


def _plain(content: Any) -> Any:
    if isinstance(content, dict):
        return {key: _plain(value) for key, value in content.items()}
    if isinstance(content, list | tuple | np.ndarray):
        return [_plain(value) for value in content]
    return None if isinstance(content, float) and not math.isfinite(content) else content


def _parameter(parameter: ParameterEstimate) -> dict[str, Any]:
    return {name: getattr(parameter, name) for name in _Parameter.model_fields}


def _run(estimate: Estimate, run: Comparison) -> dict[str, Any]:
    """A run with what was estimated of it by itself; null for what it hasn't."""
    circumstances = estimate.circumstances.get(run.name)
    cabled = circumstances is not None and run.kind != "motor_step"
    keys = {
        "clock_offset": "clock_offset_s",
        "clock_drift": "clock_drift",
        "knock": "knock_N",
        "knock_arm": "knock_arm_m",
    }
    numbers = {
        key: float(getattr(circumstances, name)) if cabled else None
        for name, key in keys.items()
    }
    return {
        "name": run.name,
        "kind": run.kind,
        "fitted": not run.held_out,
        **numbers,
        "beginning": _beginning(circumstances, BEGINNING if cabled else TURNING_DRIVES),
    }


def _beginning(
    circumstances: Circumstances | None, names: Sequence[str]
) -> dict[str, float] | None:
    """How a run begins in SI units; zeros for one at rest, null where none begins in motion."""
    if circumstances is None or circumstances.beginning is None:
        return None
    return {name: float(getattr(circumstances.beginning, name)) for name in names}


def _residual(run: str, channel: Channel, validation: ChannelValidation) -> dict[str, Any]:
    return {
        "run": run,
        "channel": channel.name,
        "unit": channel.unit,
        "rms": channel.rms,
        "noise_sigma": channel.sigma,
        "chi_square": channel.chi_square,
        "is_noise": channel.is_noise,
        "worst_at_s": channel.worst_time,
        "fit": validation.fit,
        "whiteness_p": validation.whiteness,
        "independence_p": validation.independence,
        "verdict": validation.verdict,
    }


def _profile(profile: Profile) -> dict[str, Any]:
    return {
        "name": profile.name,
        "setting": profile.setting,
        "label": profile.label,
        "interval95": profile.ends,
        "values": profile.values,
        "misfit_rise": profile.rise,
        "threshold": profile.threshold,
    }


def _posterior(posterior: Posterior) -> list[dict[str, Any]]:
    mean, sigma, interval = posterior.mean, posterior.sigma, posterior.interval()
    return [
        {
            "name": name,
            "setting": setting,
            "mean": float(mean[k]),
            "sigma": float(sigma[k]),
            "interval95": interval[k],
            "r_hat": float(posterior.r_hat[k]),
            "effective_draws": float(posterior.effective[k]),
        }
        for k, (name, setting) in enumerate(posterior.names)
    ]


def _measured(estimate: Estimate) -> list[dict[str, Any]]:
    return [
        {
            "name": fit.measured.name,
            "setting": fit.measured.setting,
            "value": float(fit.measured.value),
            "sigma": float(fit.measured.sigma),
            "unit": fit.measured.unit,
            "fitted": fit.value,
        }
        for fit in estimate.measured_fits
    ]


def _fit(estimate: Estimate) -> dict[str, Any]:
    """How the fit came about, and which run moves what."""
    fit = estimate.fit
    return {
        "ended": fit.ended,
        "iterations": fit.iterations,
        "misfit": fit.misfit,
        "measurements": fit.measurements,
        "starts": fit.starts,
        "minima": [dataclasses.asdict(valley) for valley in fit.valleys],
        "influence": _influence(estimate.influence),
    }


def _influence(influence: Influence) -> dict[str, Any]:
    """What leaving out each run does, and the bootstrap over runs."""
    return {
        "quantities": [{"name": name, "setting": setting} for name, setting in influence.names],
        "runs": influence.runs,
        "refitted": influence.refitted,
        "value_without_run": influence.without,
        "moved_standard_errors": influence.moved,
        "moved_by_noise_standard_errors": influence.by_noise,
        "bootstrap": {
            "interval95": influence.interval95,
            "runs_that_tell": influence.telling,
            "resamples": influence.resamples,
            "seed": influence.seed,
        },
    }


class _Parameter(JsonObject):
    """A row of `parameters.json`, as far as a robot is built from it."""

    name: str
    setting: str | None
    value: float
    unit: str
    sigma: float | None = None
    interval95: tuple[float | None, float | None] = (None, None)
    status: Literal[
        "identified", "weak", "unidentifiable", "at_bound", "fixed", "model_does_not_fit"
    ]

    def estimate(self) -> ParameterEstimate:
        """The row as a fit has it: what isn't known is infinite."""
        low, high = self.interval95
        errors = {
            "sigma": math.inf if self.sigma is None else self.sigma,
            "interval95": (
                -math.inf if low is None else low,
                math.inf if high is None else high,
            ),
        }
        return ParameterEstimate(**self.model_dump() | errors)


class _Correlation(JsonObject):
    """How the fitted parameters' errors hang together."""

    names: list[str]
    matrix: list[list[float]]


class _Residual(JsonObject):
    """What a fit leaves of a channel of a run."""

    channel: str
    rms: float
    noise_sigma: float
    is_noise: bool


class ParametersDocument(JsonObject):
    """`parameters.json`, as far as a robot is built from it."""

    format: Literal[1]
    parameters: list[_Parameter]
    correlation: _Correlation | None = None
    residuals: tuple[_Residual, ...] = ()
    provenance: Provenance = UNKNOWN

    def fitted_robot(self) -> FittedRobot:
        """The robot, with exact friction.

        Returns:
            The robot with its parameters and their errors.

        Raises:
            ValueError: If a quantity isn't in its SI unit.
        """
        units = {quantity.name: quantity.unit for quantity in EVERY_QUANTITY}
        values: dict[str, float] = {}
        for row in self.parameters:
            if row.name not in units:
                continue
            if row.unit != units[row.name]:
                raise ValueError(
                    f"the unit of {row.name!r} is wrong, got {row.unit!r}, expected "
                    f"{units[row.name]!r}. Give the value in SI units."
                )
            values.setdefault(row.name, row.value)
        return FittedRobot(
            robot=exact(replace(consistent(), values)),
            parameters=tuple(row.estimate() for row in self.parameters),
            correlation=self._correlation(),
            residuals=tuple(Residual(**row.model_dump()) for row in self.residuals),
            provenance=self.provenance,
        )

    def _correlation(self) -> Float[np.ndarray, "n n"] | None:
        """Correlation of the estimated parameters in their order; None where it isn't whole."""
        rows = [row.estimate() for row in self.parameters if row.status != "fixed"]
        labels = [row.label for row in rows]
        if self.correlation is None or sorted(self.correlation.names) != sorted(labels):
            return None
        at = [self.correlation.names.index(label) for label in labels]
        rows = self.correlation.matrix
        if {len(row) for row in (rows, *rows)} - {len(at)} or not _bounded(rows):
            raise ValueError(
                f"the correlation can't be, got {len(rows)} rows for {len(at)} names, expected "
                "as many rows and columns and numbers from -1 to 1 [1]. Write the file anew "
                "with `scdpr identify`."
            )
        return np.array(rows).reshape(len(at), len(at))[np.ix_(at, at)]


def _bounded(matrix: list[list[float]]) -> bool:
    """Whether numbers may be correlations, but for rounding."""
    return all(abs(number) <= 1 + 1e-6 for row in matrix for number in row)


def read_parameters(path: pathlib.Path) -> FittedRobot:
    """Read a robot from `parameters.json`.

    Args:
        path: The file.

    Returns:
        The robot, with exact friction.

    Raises:
        ValueError: If the file isn't what `scdpr identify` writes, or can't be a robot; says
            where.
    """
    document = read_json(
        path, ParametersDocument, expected="a parameters.json", verb="identify"
    )
    try:
        fitted = document.fitted_robot()
        check_parameters(fitted.parameters)
        return fitted
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
