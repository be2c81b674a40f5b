"""What is known of a rig, and the run that would tell more of it: table and file."""

import csv
import io
import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from experiments.number_text import percent, plain
from experiments.tuning_section import Table
from identification.campaign.types import Sensors
from identification.comparison import CAMERA, ENCODERS
from identification.excitation import KNOCK_TIME, REST, STEP
from identification.misfit import ERROR_TIME
from identification.next_experiment import (
    FRAME_RATE,
    Candidate,
    Criterion,
    Rig,
    a_optimal,
    d_optimal,
    sharpest,
)
from identification.unknowns import PER_SETTING, encode
from scdpr_jax.parameters import Robot, quantity

RATE = 1000.0
"""Rate of the voltage table [Hz]."""

UNTOLD = 10.0
"""Standard error, over the size, that stands for one that nothing tells [1]."""

D_OPTIMAL, A_OPTIMAL = "d-optimal", "a-optimal"
"""What `--for` takes beside the name of a quantity."""


class Left(NamedTuple):
    """What a fit leaves of a channel."""

    name: str
    """Name of its column."""
    rms: float
    """Root mean square of the residuals, in the channel's unit."""
    sigma: float
    """Standard deviation of the sensor's noise."""
    is_noise: bool
    """Whether the residuals are noise."""


@runtime_checkable
class Known(Protocol):
    """A row of the table of parameters."""

    name: str
    setting: str | None
    value: float
    sigma: float | None
    status: str


def known_rig(
    robot: Robot,
    rows: Sequence[Known],
    correlation: Float[np.ndarray, "n n"],
    *,
    setting: str | None,
    channels: Sequence[Left],
    top_speed: float,
) -> Rig:
    """What a fit knows of a rig at one pretension.

    Args:
        robot: The robot at that pretension.
        rows: The estimated quantities.
        correlation: Their correlation.
        setting: The nominal pretension, "350 N".
        channels: What the fit leaves of each channel.
        top_speed: Largest speed of the end-effector [m/s].

    Returns:
        The rig; what belongs to other settings is left unknown, as it is.

    Raises:
        ValueError: If nothing was estimated.
    """
    # What its bound stops was taken for known in the errors of the others.
    at = [
        k
        for k, row in enumerate(rows)
        if row.status != "at_bound" and (row.name != PER_SETTING or _is(row, setting))
    ]
    if not at:
        raise ValueError(
            "nothing was estimated, got fixed parameters only. Identify the rig first."
        )
    kept = [rows[k] for k in at]
    sigma = np.array([_spread(row) for row in kept])
    told = np.array([_is_told(row) for row in kept])
    within = np.where(np.outer(told, told), correlation[np.ix_(at, at)], np.eye(len(at)))
    inverse = np.linalg.inv(within) / np.outer(sigma, sigma)
    return Rig(
        robot,
        tuple(row.name for row in kept),
        jnp.array([encode(row.name, row.value) for row in kept]),
        jnp.asarray(inverse),
        errors(channels),
        math.sqrt(12) * _noise(channels, ENCODERS, Sensors().encoder_sigma),
        top_speed,
    )


def errors(channels: Sequence[Left]) -> Sensors:
    """What a prediction will be off by, as noise of each sensor.

    Where a fit leaves more than noise the model errs, and for as long as
    `identification.misfit.ERROR_TIME`: what it leaves then counts once in that time.

    Args:
        channels: What the fit leaves of each channel.

    Returns:
        Standard deviations of noise that is worth as much.
    """
    usual, places = Sensors(), (*CAMERA[:1], *CAMERA[2:])
    return Sensors(
        encoder_sigma=_error(channels, ENCODERS, usual.encoder_sigma, RATE),
        camera_position_sigma=_error(channels, places, usual.camera_position_sigma, FRAME_RATE),
        camera_angle_sigma=_error(channels, CAMERA[1:2], usual.camera_angle_sigma, FRAME_RATE),
    )


def _noise(channels: Sequence[Left], names: Sequence[str], usual: float) -> float:
    found = [one.sigma for one in channels if one.name in names]
    return float(np.median(found)) if found else usual


def _error(channels: Sequence[Left], names: Sequence[str], usual: float, rate: float) -> float:
    noise = _noise(channels, names, usual)
    found = [one for one in channels if one.name in names]
    if all(one.is_noise for one in found):
        return noise
    typical = float(np.median([one.rms for one in found]))
    return max(noise, typical * math.sqrt(rate * ERROR_TIME))


def _is(row: Known, setting: str | None) -> bool:
    return setting is None or row.setting in (setting, None)


def _is_told(row: Known) -> bool:
    return row.sigma is not None and math.isfinite(row.sigma) and row.sigma > 0


def _spread(row: Known) -> float:
    """Standard error of a quantity as a fit holds it."""
    size = row.value if quantity(row.name).positive else 1.0
    if _is_told(row):
        return row.sigma / size
    return UNTOLD * (1.0 if quantity(row.name).positive else max(abs(row.value), 1.0))


def criterion_for(wanted: str, rig: Rig) -> Criterion:
    """What is to be minimised.

    Args:
        wanted: Name of a quantity, or `D_OPTIMAL` or `A_OPTIMAL` for all of them.
        rig: What is known of the rig.

    Returns:
        The criterion.

    Raises:
        ValueError: If the quantity isn't among the estimated ones.
    """
    if wanted.lower() == D_OPTIMAL:
        return d_optimal
    if wanted.lower() == A_OPTIMAL:
        return a_optimal(_now(rig))
    if wanted not in rig.names:
        raise ValueError(
            f"`--for` names nothing that was estimated, got {wanted!r}, expected one of: "
            f"{', '.join(rig.names)}, {D_OPTIMAL}, {A_OPTIMAL}. Free it in `scdpr identify` "
            "first, or name one of these."
        )
    return sharpest(rig.names.index(wanted))


def _now(rig: Rig) -> Float[np.ndarray, " n"]:
    return np.sqrt(np.diag(np.linalg.inv(np.asarray(rig.earlier))))


def candidate_table(rig: Rig, wanted: str, candidates: Sequence[Candidate]) -> Table:
    """The candidates, the best one first.

    Args:
        rig: What is known of the rig.
        wanted: What `criterion_for` was asked for.
        candidates: What to choose from.

    Returns:
        A row for each.
    """
    single = wanted in rig.names
    rows = []
    for one in candidates:
        errors = ()
        if single:
            at = rig.names.index(wanted)
            errors = (_shown(rig, at, _now(rig)[at]), _shown(rig, at, one.sigma[at]))
        run = one.excitation
        rows.append(
            (
                run.name,
                f"{run.start[0]:.2f}, {run.start[1]:.2f}",
                f"{run.duration:.2f}",
                *errors,
                plain(math.exp(one.gain), 3),
                plain(one.rate, 3),
            )
        )
    header = (
        "run",
        "start x, y [m]",
        "rig time [s]",
        *((f"σ of {wanted.replace('_', ' ')} now", "with it") if single else ()),
        "smaller by a factor",
        "its logarithm a second [1/s]",
    )
    what = wanted.replace("_", " ") if single else f"all quantities, {wanted.lower()}"
    return Table(f"What the next run would tell: {what}", header, tuple(rows))


def _shown(rig: Rig, index: int, sigma: float) -> str:
    name, held = rig.names[index], float(rig.point[index])
    if quantity(name).positive:
        return percent(float(sigma))
    unit = quantity(name).unit
    share = f" ({percent(float(sigma) / abs(held))})" if held else ""
    return f"{sigma:.2g}{'' if unit == '1' else ' ' + unit}{share}"


def instructions(candidate: Candidate) -> tuple[str, ...]:
    """How to make a run, in words.

    Args:
        candidate: The run.

    Returns:
        Sentences.
    """
    run = candidate.excitation
    place = f"Let the end-effector rest at x = {run.start[0]:.3f} m, y = {run.start[1]:.3f} m"
    if run.knock:
        return (
            f"{place}, the drives held at 0 V, and knock it sideways {REST:g} s after the log "
            f"begins, with some {run.knock:g} N for {KNOCK_TIME:g} s. Log kind "
            '"pseudo_impulse".',
        )
    largest = float(np.max(np.abs(run.voltage)))
    return (
        f"{place}, and play the voltages, at most {largest:.1f} V, in open loop. Log kind "
        '"torque_step". Stop it by hand if it comes near the frame: the prediction is only as '
        "good as the model.",
    )


def caution(channels: Sequence[Left]) -> tuple[str, ...]:
    """What the predictions rest on.

    Args:
        channels: What the fit leaves of each channel.

    Returns:
        Sentences.
    """
    if all(one.is_noise for one in channels):
        return (
            "Predicted for sensors with the noise of the earlier runs, and a model that fits.",
        )
    return (
        "The fit leaves more than noise. The prediction counts what it leaves as an error "
        f"that stands for {ERROR_TIME:g} s; how far another run departs from the model it "
        "can't know.",
    )


def voltage_table(candidate: Candidate) -> str:
    """A run as CSV at the rate of the logs, each row held until the next.

    Args:
        candidate: The run.

    Returns:
        The table; its last row is 0 V.
    """
    each = round(STEP * RATE)
    voltage = np.repeat(candidate.excitation.voltage, each, axis=0)
    voltage = np.concatenate([voltage, np.zeros((1, 2))])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("t [s]", "voltage_1 [V]", "voltage_2 [V]"))
    for number, (first, second) in enumerate(voltage):
        writer.writerow((f"{number / RATE:.3f}", f"{first:.6g}", f"{second:.6g}"))
    return text.getvalue()
