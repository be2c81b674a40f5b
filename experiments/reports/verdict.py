"""What an estimate comes to, in numbers and in plain words."""

import math
from typing import NamedTuple

import numpy as np

from experiments.page.coordinates import COORDINATES
from experiments.page.number_text import percent, plain, readable_unit, rounded
from experiments.reports.measured_section import contradictions
from experiments.reports.model_section import verdict_on_models
from identification.campaign.types import Campaign
from identification.fit.comparison import ENCODERS, Channel, Comparison
from identification.fit.unknowns.unknowns import PER_SETTING
from identification.judge.uncertainty import USUAL, ParameterEstimate, half_width
from identification.judge.validation import LEVEL, validate
from identification.knocks.frequency_map import FrequencyMap
from identification.result.estimate import Estimate
from scdpr_jax.robot.parameters import value

FRICTION = "friction_coefficient"

_LISTED = 3  # runs that are told one by one


class Excess(NamedTuple):
    """A channel whose residual is more than noise."""

    run: str
    """Name of the run."""
    channel: Channel
    """The channel."""
    size: float
    """Root mean square of the residual at the end-effector [m]; of a rotation [rad]."""


class Prediction(NamedTuple):
    """How well a held-out run was predicted."""

    run: str
    """Name of the run."""
    error: float
    """Root mean square distance from the measured positions [m]."""
    largest: float
    """Largest distance [m]."""
    motion: float
    """Largest extent of the measured motion [m]."""

    @property
    def share(self) -> float:
        """Error over motion [1]; infinite for a run that didn't move."""
        return self.error / self.motion if self.motion > 0 else math.inf


class FrictionForce(NamedTuple):
    r"""Friction of a carriage at the aligned pose, $4 T \mu$."""

    setting: str | None
    """Nominal pretension."""
    force: float
    """Force [N]."""
    half_width: float
    """Half of its 95 % interval [N]."""


def excesses(estimate: Estimate) -> tuple[Excess, ...]:
    """Channels of the fitted runs whose residuals are more than noise, the worst first.

    Args:
        estimate: The estimate.

    Returns:
        The channels, by how far they exceed the noise.
    """
    radius = float(value(estimate.robot, "effective_radius"))
    found = [
        Excess(run.name, channel, channel.rms * (radius if channel.name in ENCODERS else 1.0))
        for run in estimate.comparisons
        if not run.held_out
        for channel in run.channels
        if not channel.is_noise
    ]
    return tuple(sorted(found, key=lambda excess: -excess.channel.chi_square))


def prediction(comparison: Comparison, *, radius: float) -> Prediction:
    """How far a simulation is from what was measured.

    Where the camera saw the end-effector that counts; elsewhere the encoders do, whose
    turns are taken as path along the cable.

    Args:
        comparison: The run.
        radius: Effective radius of the driver pulleys [m].

    Returns:
        Its errors.
    """
    columns = [0, 4]
    measured, simulated = comparison.measured[:, columns], comparison.simulated[:, columns]
    seen = np.all(np.isfinite(measured), axis=1)
    if not np.any(seen):
        measured, simulated = (
            radius * angle for angle in (comparison.measured_angle, comparison.simulated_angle)
        )
        seen = np.all(np.isfinite(measured), axis=1)
    distance = np.linalg.norm(measured[seen] - simulated[seen], axis=1)
    return Prediction(
        run=comparison.name,
        error=float(np.sqrt(np.mean(np.square(distance)))),
        largest=float(distance.max()),
        motion=float(np.linalg.norm(np.ptp(measured[seen], axis=0))),
    )


def predictions(estimate: Estimate) -> tuple[Prediction, ...]:
    """How well the held-out runs were predicted.

    Args:
        estimate: The estimate.

    Returns:
        One for each held-out run.
    """
    radius = float(value(estimate.robot, "effective_radius"))
    return tuple(prediction(run, radius=radius) for run in estimate.comparisons if run.held_out)


def friction_forces(estimate: Estimate) -> tuple[FrictionForce, ...]:
    r"""Friction force $4 T \mu$ of each setting, which the data determine best.

    Args:
        estimate: The estimate.

    Returns:
        One for each pretension setting whose friction was estimated.
    """
    free = estimated(estimate)
    names = [(parameter.name, parameter.setting) for parameter in free]
    if (FRICTION, None) not in names:
        return ()
    mu_at = names.index((FRICTION, None))
    mu, found = free[mu_at], []
    for index, parameter in enumerate(free):
        if parameter.name != PER_SETTING or mu.value == 0:
            continue
        if not math.isfinite(parameter.sigma + mu.sigma):
            continue
        force = 4 * parameter.value * mu.value
        shares = (parameter.sigma / parameter.value, mu.sigma / mu.value)
        together = 2 * float(estimate.correlation[index, mu_at]) * shares[0] * shares[1]
        variance = shares[0] ** 2 + shares[1] ** 2 + together
        sigma = force * math.sqrt(max(variance, 0.0))
        half = half_width(sigma, 0.95, parameter.degrees_of_freedom)
        found.append(FrictionForce(parameter.setting, force, half))
    return tuple(found)


def estimated(estimate: Estimate) -> tuple[ParameterEstimate, ...]:
    """The parameters that were estimated, in the order of the correlation matrix.

    Args:
        estimate: The estimate.

    Returns:
        All that aren't fixed.
    """
    return tuple(p for p in estimate.parameters if p.status != "fixed")


def shown_size(excess: Excess) -> str:
    """The size of a residual in the unit that it is read in.

    Args:
        excess: The channel.

    Returns:
        "0.31 mm" or "0.2°".
    """
    if excess.channel.name == "delta_e":
        return f"{plain(math.degrees(excess.size))}°"
    return f"{plain(1e3 * excess.size)} mm"


class Words(NamedTuple):
    """The summary: what was found, how sure, and what to do next."""

    found: tuple[str, ...]
    """What was found, a sentence each."""
    sure: tuple[str, ...]
    """How far it can be trusted."""
    next: tuple[str, ...]
    """What to do next."""


def words(
    campaign: Campaign | None,
    estimate: Estimate,
    *,
    frequencies: FrequencyMap | None,
    tuned: bool,
) -> Words:
    """The summary in plain words.

    Args:
        campaign: The campaign, None if nothing is to be said of its clocks and faults.
        estimate: What was found in it.
        frequencies: Its natural frequencies, None without.
        tuned: Whether gains and shapers were made from it.

    Returns:
        The sentences.
    """
    found = [_parameter(parameter) for parameter in estimated(estimate)]
    for friction in friction_forces(estimate):
        at = "" if friction.setting is None else f" at {friction.setting}"
        half = friction.half_width
        found.append(
            f"Friction force of a carriage{at}, 4Tμ: {rounded(friction.force, half)} ± "
            f"{rounded(half, half)} N (95 %)."
        )
    if frequencies is not None:
        found.append(_frequencies(frequencies))
    sure = [_noise(estimate), _validated(estimate), *verdict_on_models(estimate)]
    sure += contradictions(estimate)
    sure += _untold(estimate)
    sure += [_held_out(one) for one in predictions(estimate)]
    sure += _ending(estimate)
    if campaign is not None:
        sure += _clocks(campaign, estimate)
        sure += _skipped(campaign)
    return Words(tuple(found), tuple(sure), tuple(_next(estimate, frequencies, tuned)))


def _validated(estimate: Estimate) -> str:
    """What whiteness and independence say of the fitted and of the held-out runs."""
    found = [one for run in estimate.comparisons for one in validate(run)]
    tested = [one for one in found if one.is_rounding or not math.isnan(one.whiteness)]
    worse = [one for one in tested if one.verdict != "noise"]
    follows = sum(one.independence < LEVEL for one in worse)
    hangs = len(worse) - follows
    return (
        f"Of {len(tested)} channels that are long enough to test, "
        f"{len(tested) - follows - hangs} leave white residuals that know nothing of the "
        f"voltages, or an encoder's rounding; {follows} follow the voltages, and {hangs} more "
        "hang together in time."
    )


def _untold(estimate: Estimate) -> list[str]:
    """Why a quantity can't be told, or hardly."""
    badly = [p for p in estimated(estimate) if p.status in ("weak", "unidentifiable")]
    reasons = [estimate.identifiability.reason(p.name, p.setting) for p in badly]
    return list(dict.fromkeys(reasons))


def _parameter(parameter: ParameterEstimate) -> str:
    setting = "" if parameter.setting is None else f" at {parameter.setting}"
    name = parameter.name.replace("_", " ").capitalize() + setting
    unit = "" if parameter.unit == "1" else f" {readable_unit(parameter.unit)}"
    if parameter.status == "unidentifiable":
        return f"{name} can't be told from these runs."
    if parameter.status == "at_bound":
        return f"{name} came to rest at its bound, {rounded(parameter.value, 0)}{unit}."
    half = half_width(parameter.sigma, 0.95, parameter.degrees_of_freedom)
    if parameter.name in USUAL and parameter.value <= half:
        most = rounded(parameter.value + half, half)
        return f"{name}: {most}{unit} at the most (95 %); the runs don't ask for any."
    relative = f", {percent(half / abs(parameter.value))}" if parameter.value else ""
    weak = "; only weakly identified" if parameter.status == "weak" else ""
    return (
        f"{name}: {rounded(parameter.value, half)} ± {rounded(half, half)}{unit} "
        f"(95 %{relative}{weak})."
    )


def _frequencies(frequencies: FrequencyMap) -> str:
    low, high = float(frequencies.frequency.min()), float(frequencies.frequency.max())
    knocks = len(frequencies.runs)
    poses = "one pose" if knocks == 1 else f"{knocks} poses"
    lost = len(frequencies.unresolved)
    without = "" if lost == 0 else f" {lost} more gave none."
    return (
        f"Knocks at {poses} ring at {plain(low, 3)} to {plain(high, 3)} Hz, with damping "
        f"ratios up to {percent(float(frequencies.damping_ratio.max()))}.{without}"
    )


def _noise(estimate: Estimate) -> str:
    fitted = [run for run in estimate.comparisons if not run.held_out]
    total = sum(len(run.channels) for run in fitted)
    worse = excesses(estimate)
    if not worse:
        return (
            f"The residuals of all {total} channels of {len(fitted)} fitted runs may be the "
            "sensors' noise: the model explains what was measured."
        )
    listed = "; ".join(
        f"{excess.run}, {COORDINATES[excess.channel.name].symbol}: {shown_size(excess)} rms "
        f"({plain(math.sqrt(excess.channel.chi_square))} times the noise), worst at "
        f"{excess.channel.worst_time:.2f} s"
        for excess in _one_a_run(worse)[:_LISTED]
    )
    return (
        f"The residuals are NOT only noise: {len(worse)} of {total} channels of the "
        f"{len(fitted)} fitted runs have more. The worst: {listed}. The model doesn't "
        "explain these, and the values are the best for this model only."
    )


def _one_a_run(found: tuple[Excess, ...]) -> list[Excess]:
    """The first of each run, in their order."""
    first: dict[str, Excess] = {}
    for excess in found:
        first.setdefault(excess.run, excess)
    return list(first.values())


def _held_out(one: Prediction) -> str:
    share = f", {percent(one.share)} of its motion" if math.isfinite(one.share) else ""
    return (
        f"Run {one.run}, which was not fitted, is predicted to {plain(1e3 * one.error)} mm "
        f"rms{share} of {plain(1e3 * one.motion, 3)} mm; at the worst to "
        f"{plain(1e3 * one.largest)} mm."
    )


def _clocks(campaign: Campaign, estimate: Estimate) -> list[str]:
    unknown = [
        run.name
        for run in campaign.runs
        if run.clock_offset is None
        and run.camera is not None
        and run.name in estimate.circumstances
    ]
    drifting = _drifts(campaign, estimate)
    if not unknown:
        return drifting
    offsets = {name: 1e3 * float(estimate.circumstances[name].clock_offset) for name in unknown}
    told = "; ".join(f"{name} {plain(offset, 3)} ms" for name, offset in offsets.items())
    if len(offsets) > _LISTED:
        low, high = min(offsets.values()), max(offsets.values())
        told = f"{plain(low, 3)} to {plain(high, 3)} ms in {len(offsets)} runs"
    return [
        f"The camera's clock was unknown and estimated, camera minus drive: {told}.",
        *drifting,
    ]


def _drifts(campaign: Campaign, estimate: Estimate) -> list[str]:
    seen = [
        estimate.circumstances[run.name]
        for run in campaign.runs
        if run.camera is not None and run.name in estimate.circumstances
    ]
    if not (estimate.clock_drifts and seen):
        return []
    drifts = [1e6 * float(own.clock_drift) for own in seen]
    return [
        f"By the fit the cameras' clocks run {plain(min(drifts), 3)} to "
        f"{plain(max(drifts), 3)} ppm faster than the drives'."
    ]


def _skipped(campaign: Campaign) -> list[str]:
    return [
        f"Run {name} was skipped: {faults[0] if faults else 'no reason given'}"
        for name, faults in campaign.skipped
    ]


def _ending(estimate: Estimate) -> list[str]:
    if estimate.fit.ended == "converged":
        return []
    reason = {
        "stalled": "ended where a run only just stops or doesn't, at a kink of the misfit",
        "unfinished": "used up its iterations before its stopping rule was met",
    }.get(estimate.fit.ended, f"ended as {estimate.fit.ended}")
    return [f"The fit {reason}: the standard errors may be too small."]


def _next(estimate: Estimate, frequencies: FrequencyMap | None, tuned: bool) -> list[str]:
    steps = []
    for parameter in estimated(estimate):
        name = parameter.name.replace("_", " ")
        if parameter.status in ("weak", "unidentifiable"):
            steps.append(f"Log runs that excite the {name}: it is {parameter.status} so far.")
        if parameter.status == "at_bound" and excesses(estimate):
            steps.append(
                f"Ask whether the {name} is zero indeed, or the model lacks something."
            )
    if excesses(estimate):
        steps.append(
            "Look at the residuals of the worst run below: a step points to friction, a sine "
            "to stiffness or mass, a slope to a drive or a clock."
        )
    if not predictions(estimate):
        steps.append("Hold a run out next time, to see how well the model predicts.")
    if frequencies is None:
        steps.append("Log knocks over the workspace: shapers need the natural frequencies.")
    if tuned:
        steps.append(
            "Set the gains and shapers on the rig, starting with a slow manoeuvre, log it, and "
            "hold it against the prediction."
        )
    elif not steps:
        steps.append("Use the parameters: tune the controller and the shapers with them.")
    return steps
