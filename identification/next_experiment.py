r"""Which experiment next: the excitation that sharpens what is known most per second.

Fisher's information of a run that hasn't been made is that of its simulation: its Jacobian in
units of the sensors' noise, the start and the force of a knock taken off by the Schur
complement. It adds to what the earlier runs hold. A criterion of the sum is minimised over
the voltages, by reverse mode through the forward-mode Jacobian, within the voltages' limit,
the frame and a speed.
"""

import dataclasses
from collections.abc import Callable, Sequence
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float

from identification.campaign.types import Sensors
from identification.excitation import KNOCK_TIME, REST, STEP, Excitation, moving
from identification.record import Record
from identification.residuals import Circumstances, encoder_residuals, predict
from identification.unknowns import apply
from scdpr_jax.parameters import Robot, value
from scdpr_jax.stepping import Inputs

FRAME_RATE = 30.0
"""Rate of the camera [Hz]."""

MARGIN = 0.1
"""How far the end-effector stays clear of the frame beyond its own size [m]."""

SOFTNESS = 0.01
"""Excursion beyond a limit that costs as much as a unit of the criterion [m, or m/s]."""

KNOTS = 24
"""Knots of what the search adds to each voltage."""

LANES = 8
"""Excitations that are simulated side by side."""

Criterion = Callable[[Float[Array, "n n"]], Float[Array, ""]]
"""What is minimised, of the information about the quantities."""


def d_optimal(information: Float[Array, "n n"]) -> Float[Array, ""]:
    """Mean logarithm of the confidence ellipsoid's axes, up to a constant.

    Args:
        information: Fisher's information.

    Returns:
        The criterion [1].
    """
    return -jnp.linalg.slogdet(information)[1] / (2 * information.shape[0])


def a_optimal(now: Float[np.ndarray, " n"]) -> Criterion:
    """The criterion of the mean variance, each over what it is now.

    Args:
        now: Standard errors now.

    Returns:
        The criterion: half of its logarithm.
    """

    def criterion(information: Float[Array, "n n"]) -> Float[Array, ""]:
        variance = jnp.diag(_covariance(information))
        return jnp.log(jnp.mean(variance / jnp.square(jnp.asarray(now)))) / 2

    return criterion


def sharpest(index: int) -> Criterion:
    """The criterion that minds a single quantity: its standard error's logarithm.

    Args:
        index: Number of the quantity.

    Returns:
        The criterion.
    """
    return lambda information: jnp.log(_covariance(information)[index, index]) / 2


def _covariance(information: Float[Array, "n n"]) -> Float[Array, "n n"]:
    scale = 1 / jnp.sqrt(jnp.diag(information))
    both = jnp.outer(scale, scale)
    return jnp.linalg.inv(information * both) * both


class Rig(NamedTuple):
    """What is known of the rig that the experiment is for."""

    robot: Robot
    """The robot as far as it is known, with exact friction."""
    names: tuple[str, ...]
    """The quantities that aren't known exactly."""
    point: Float[Array, " n"]
    """Their values as a fit holds them."""
    earlier: Float[Array, "n n"]
    """Information about them from the earlier runs."""
    sensors: Sensors
    """The sensors' noise, with what the model errs by."""
    count: float
    """Count of the encoders [rad]."""
    top_speed: float
    """Largest speed of the end-effector in either direction [m/s]."""
    log_rate: float = 1000.0
    """Rate of the logs [Hz]."""


class Judged(NamedTuple):
    """What an excitation would give."""

    information: Float[Array, "n n"]
    """Information about the quantities with that of the earlier runs."""
    beyond: Float[Array, ""]
    """How far it goes beyond the frame's margin and the speed [m, m/s]; 0 for allowed."""


@dataclasses.dataclass(frozen=True, eq=False)
class Candidate:
    """An excitation and what it is worth."""

    excitation: Excitation
    """The excitation."""
    sigma: Float[np.ndarray, " n"]
    """Standard errors of the quantities with it, as a fit holds them."""
    gain: float
    """Fall of the criterion, a logarithm of standard errors [1]."""
    designed: bool
    """Whether it was found by gradient rather than taken from the catalogue."""

    @property
    def rate(self) -> float:
        """Fall of the criterion per second of rig time [1/s]."""
        return self.gain / self.excitation.duration


def run_information(
    rig: Rig,
    voltage: Float[Array, "intervals 2"],
    begin: Float[Array, "4"],
    length: Float[Array, ""],
) -> Judged:
    """What a run would tell of the quantities.

    Args:
        rig: The rig.
        voltage: Commands, each held for `STEP` [V].
        begin: Start of the end-effector [m], [m], force of the knock [N], and whether that
            is unknown, 1 or 0.
        length: Intervals of the run; the others have no length.

    Returns:
        Information, the earlier runs' included, and excursions.
    """
    count, shared = voltage.shape[0], len(rig.names)
    record = _record(rig, voltage, length)
    x, y, force, knocked = begin

    def measured(
        unknown: Float[Array, " m"],
    ) -> tuple[tuple[Array, Array], tuple[Array, Array, Array]]:
        robot = apply(rig.robot, rig.names, unknown[:shared])
        lower, upper, height, knock = unknown[shared:]
        own = Circumstances(lower, upper, height, knock, 0.0)
        states, angle, frame = predict(robot, own, record)
        return (angle, frame), (angle, states.position, states.velocity)

    point = jnp.concatenate([rig.point, jnp.stack([x, x, y, force])])
    (turned, seen), (angle, position, velocity) = jax.jacfwd(measured, has_aux=True)(point)
    weight = _encoder_weight(rig, angle, record)
    columns = jax.vmap(lambda own: encoder_residuals(own, weight), in_axes=2, out_axes=2)
    rows = jnp.concatenate(
        [
            columns(turned).reshape(-1, point.size),
            (record.frame_weight[..., None] * seen).reshape(-1, point.size),
        ]
    )
    known = jnp.square(jnp.concatenate([record.known_weight[:3], 1.0 - knocked[None]]))
    whole = rows.T @ rows
    own = whole[shared:, shared:] + jnp.diag(known)
    taken = whole[:shared, shared:] @ _covariance(own) @ whole[shared:, :shared]
    active = (jnp.arange(count + 1, dtype=float) <= length)[:, None]
    return Judged(
        rig.earlier + whole[:shared, :shared] - taken,
        _beyond(
            rig, jnp.where(active, position, position[:1]), jnp.where(active, velocity, 0.0)
        ),
    )


def propose(
    rig: Rig,
    excitations: Sequence[Excitation],
    criterion: Criterion,
    *,
    iterations: int = 40,
    progress: Callable[[str, float], None] = lambda doing, share: None,
) -> tuple[Candidate, ...]:
    """The best excitation of each shape, and what a search by gradient makes of them.

    Reference: A. C. Atkinson, A. N. Donev, R. D. Tobias, "Optimum experimental designs, with
    SAS", Oxford 2007: the criteria.

    Args:
        rig: What is known of the rig.
        excitations: The catalogue.
        criterion: `d_optimal`, `a_optimal` or `sharpest(index)`.
        iterations: Steps of the search; 0 for the catalogue alone.
        progress: Told what is being done and which share of it is done.

    Returns:
        Those that keep within voltage, frame and speed, the one that makes the criterion
        fall most per second first.

    Raises:
        ValueError: If no excitation of the catalogue keeps within frame and speed.
    """
    before = float(criterion(rig.earlier))
    found = _judged(rig, excitations, criterion, before, progress)
    best: dict[str, Candidate] = {}
    for one in sorted(found, key=lambda one: -one.rate):
        best.setdefault(one.excitation.name.split(",")[0], one)
    if not best:
        raise ValueError(
            f"no excitation keeps {MARGIN:g} m clear of the frame and below "
            f"{rig.top_speed:g} m/s, got {len(excitations)} to choose from. Allow for a higher "
            "speed or start elsewhere."
        )
    starts = [one for one in best.values() if one.excitation.knock == 0]
    designed = []
    if starts and iterations:
        designed = _designed(rig, starts, criterion, before, iterations, progress)
    return tuple(sorted((*best.values(), *designed), key=lambda one: -one.rate))


class _Padded(NamedTuple):
    """Excitations as arrays of one size."""

    voltage: Float[Array, "lanes intervals 2"]
    begin: Float[Array, "lanes 4"]
    length: Float[Array, " lanes"]


def _padded(excitations: Sequence[Excitation], intervals: int) -> _Padded:
    each = [
        (
            np.pad(one.voltage, [(0, intervals - one.voltage.shape[0]), (0, 0)]),
            [*one.start, one.knock, float(one.knock != 0)],
            float(one.voltage.shape[0]),
        )
        for one in excitations
    ]
    return _Padded(*(jnp.asarray(np.array(part)) for part in zip(*each, strict=True)))


@eqx.filter_jit
def _all_information(rig: Rig, runs: _Padded) -> Judged:
    return jax.vmap(lambda run: run_information(rig, *run))(runs)


def _judged(
    rig: Rig,
    excitations: Sequence[Excitation],
    criterion: Criterion,
    before: float,
    progress: Callable[[str, float], None],
) -> list[Candidate]:
    """What the excitations are worth that keep within the limits."""
    intervals = max(one.voltage.shape[0] for one in excitations)
    found = []
    for first in range(0, len(excitations), LANES):
        progress("the catalogue", first / len(excitations) / 2)
        chunk = list(excitations[first : first + LANES])
        # Chunks of one size: one compilation.
        told = _all_information(
            rig, _padded(chunk + chunk[:1] * (LANES - len(chunk)), intervals)
        )
        for one, information, beyond in zip(chunk, told.information, told.beyond, strict=False):
            if float(beyond) == 0.0:
                found.append(_candidate(one, information, criterion, before, designed=False))
    return found


def _candidate(
    excitation: Excitation,
    information: Float[Array, "n n"],
    criterion: Criterion,
    before: float,
    *,
    designed: bool,
) -> Candidate:
    sigma = np.sqrt(np.diag(np.asarray(_covariance(information))))
    return Candidate(excitation, sigma, before - float(criterion(information)), designed)


@eqx.filter_jit
def _sloped(
    rig: Rig,
    criterion: Criterion,
    knots: Float[Array, "lanes knots 2"],
    base: Float[Array, "lanes intervals 2"],
    spread: Float[Array, "lanes intervals knots"],
    runs: _Padded,
) -> tuple[Float[Array, "lanes knots 2"], Judged, Float[Array, "lanes intervals 2"]]:
    """Slope of the penalised criterion over the knots, with what it is the slope of."""
    limit = rig.robot.drive.voltage_limit

    def cost(own, base, spread, run):
        moves = jnp.any(spread > 0, axis=1)[:, None]
        voltage = limit * jnp.where(moves, jnp.tanh(base + spread @ own), 0.0)
        told = run_information(rig, voltage, run.begin, run.length)
        return criterion(told.information) + told.beyond / SOFTNESS, (told, voltage)

    slope, (told, voltage) = jax.vmap(jax.grad(cost, has_aux=True))(knots, base, spread, runs)
    return slope, told, voltage


def _designed(
    rig: Rig,
    starts: Sequence[Candidate],
    criterion: Criterion,
    before: float,
    iterations: int,
    progress: Callable[[str, float], None],
) -> list[Candidate]:
    """What Adam's steps make of some starts; the best of each that keeps within limits."""
    chosen = [one.excitation for one in starts]
    intervals = max(one.voltage.shape[0] for one in chosen)
    runs = _padded(chosen, intervals)
    limit = float(value(rig.robot, "voltage_limit"))
    base = jnp.arctanh(0.98 * runs.voltage / limit)
    spread = jnp.asarray(np.stack([_hats(int(n), intervals) for n in runs.length]))
    knots = jnp.zeros((len(chosen), KNOTS, 2))
    optimiser = optax.adam(0.05)
    state, best = optimiser.init(knots), list(starts)
    for number in range(iterations):
        progress("designed by gradient", 0.5 + number / iterations / 2)
        slope, told, voltage = _sloped(rig, criterion, knots, base, spread, runs)
        for lane, one in enumerate(chosen):
            if float(told.beyond[lane]) > 0.0:
                continue
            moved = dataclasses.replace(
                one,
                name=f"designed from {one.name.split(',')[0]}",
                voltage=np.asarray(voltage[lane, : one.voltage.shape[0]]),
            )
            tried = _candidate(moved, told.information[lane], criterion, before, designed=True)
            best[lane] = max(best[lane], tried, key=lambda candidate: candidate.gain)
        slope = jnp.where(jnp.isfinite(slope), slope, 0.0)
        # optax raises a float to the power of an integer count.
        with jax.numpy_dtype_promotion("standard"):
            change, state = optimiser.update(slope, state)
        knots = optax.apply_updates(knots, change)
    return [one for one in best if one.designed]


def _hats(length: int, intervals: int) -> Float[np.ndarray, "intervals knots"]:
    """Linear interpolation between knots over the time in which a run may move."""
    at = np.flatnonzero(moving(length))
    place = np.linspace(0, KNOTS - 1, at.size)
    spread = np.zeros((intervals, KNOTS))
    spread[at] = np.maximum(1 - np.abs(place[:, None] - np.arange(KNOTS)[None]), 0.0)
    return spread


def _record(rig: Rig, voltage: Float[Array, "intervals 2"], length: Float[Array, ""]) -> Record:
    count, sensors = voltage.shape[0], rig.sensors
    number = jnp.arange(count, dtype=float)
    stamps = (jnp.arange(round(count * STEP * FRAME_RATE), dtype=float) + 0.5) / FRAME_RATE
    before = round(REST * FRAME_RATE)
    seen = (stamps > REST) & (stamps < length * STEP)
    noise = jnp.array([sensors.camera_position_sigma] * 5)
    noise = noise.at[1].set(sensors.camera_angle_sigma)
    begun = round(REST / STEP)
    knocked = (number >= begun) & (number < begun + round(KNOCK_TIME / STEP))
    rows = jnp.zeros((count + 1, 2))
    known = jnp.full(4, jnp.sqrt(1.0 * before) / sensors.camera_position_sigma)
    return Record(
        inputs=Inputs(
            jnp.where(number < length, STEP, 0.0), voltage, jnp.where(knocked, 1.0, 0.0)
        ),
        angle=rows,
        angle_weight=jnp.where(
            (jnp.arange(count + 1, dtype=float) <= length)[:, None], 1.0, rows
        ),
        angle_share=rows,
        frame_time=stamps,
        frame=jnp.zeros((stamps.size, 5)),
        frame_weight=jnp.where(seen[:, None], 1 / noise[None], 0.0),
        known=jnp.zeros(4),
        known_weight=known,
    )


def _encoder_weight(
    rig: Rig, angle: Float[Array, "rows 2"], record: Record
) -> Float[Array, "rows 2"]:
    """Inverse standard deviations of all readings about each instant.

    A drive that turns by less than a count from sample to sample repeats its reading, which
    is one measurement (`identification.record.readings`): there are as many as counts passed.
    """
    moved = jnp.abs(jnp.diff(angle, axis=0, prepend=angle[:1]))
    measurements = jnp.clip(moved / rig.count, 1e-2, STEP * rig.log_rate)
    return record.angle_weight * jnp.sqrt(measurements) / rig.sensors.encoder_sigma


def _beyond(
    rig: Rig, position: Float[Array, "rows 5"], velocity: Float[Array, "rows 5"]
) -> Float[Array, ""]:
    """How far a motion leaves its limits."""
    body, frame = rig.robot.end_effector, rig.robot.frame
    low = jnp.stack([jnp.asarray(MARGIN), body.lower_offset + MARGIN])
    high = jnp.stack([frame.width - MARGIN, frame.height - body.upper_offset - MARGIN])
    at = jnp.array([0, 4])
    place, speed = position[:, at], jnp.abs(velocity[:, at])
    out = jnp.maximum(low[None] - place, 0.0) + jnp.maximum(place - high[None], 0.0)
    return jnp.max(out) + jnp.max(jnp.maximum(speed - rig.top_speed, 0.0))
