"""The run that would tell more of a rig: its table, its voltages, and what they rest on."""

import csv
import io
import math
from collections.abc import Sequence
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from experiments.page.number_text import percent, plain
from experiments.page.table import Table
from identification.campaign.abbreviation import full_names
from identification.judge.uncertainty import half_width
from identification.next_run.excitation import KNOCK_TIME, REST, STEP
from identification.next_run.expected_information import Rig, motion
from identification.next_run.next_experiment import (
    Candidate,
    Criterion,
    a_optimal,
    d_optimal,
    sharpest,
    stacked,
)
from scdpr_jax.robot.quantities import quantity
from scdpr_jax.robot.state import pose

RATE = 1000.0
"""Rate of the voltage table [Hz]."""

D_OPTIMAL, A_OPTIMAL = "d-optimal", "a-optimal"
"""What `--for` takes beside the name of a quantity."""


class Aim(NamedTuple):
    """What the next run is for."""

    criterion: Criterion
    """What is minimised."""
    index: int | None
    """Number of the quantity that it is for, None for all of them."""
    title: str
    """It in words."""


def aim_for(wanted: str, rig: Rig) -> Aim:
    """What is to be minimised.

    Args:
        wanted: Name or symbol of a quantity, or `D_OPTIMAL` or `A_OPTIMAL` for all of them.
        rig: What is known of the rig.

    Returns:
        The aim.

    Raises:
        ValueError: If the quantity isn't among the estimated ones.
    """
    if wanted.lower() == D_OPTIMAL:
        return Aim(d_optimal, None, "all quantities, D-optimal")
    if wanted.lower() == A_OPTIMAL:
        return Aim(a_optimal(_now(rig)), None, "all quantities, A-optimal")
    try:
        (name,) = full_names((wanted,), rig.names, argument="--for", what="quantity")
    except ValueError as error:
        raise ValueError(
            f"{error} Or name {D_OPTIMAL} or {A_OPTIMAL} for all of them; what wasn't "
            "estimated, `scdpr identify --free` has to free first."
        ) from None
    index = rig.names.index(name)
    return Aim(sharpest(index), index, name.replace("_", " "))


def _now(rig: Rig) -> Float[np.ndarray, " n"]:
    return np.sqrt(np.sum(np.square(np.asarray(rig.root)), axis=1))


def candidate_table(rig: Rig, aim: Aim, candidates: Sequence[Candidate]) -> Table:
    """The candidates, the best one first.

    Args:
        rig: What is known of the rig.
        aim: What the run is for.
        candidates: What to choose from.

    Returns:
        A row for each.
    """
    title, at = f"What the next run would tell: {aim.title}", aim.index
    if at is not None:
        title += f", 95 % interval now {shown_width(rig, at, _now(rig)[at])}"
    rows = []
    for one in candidates:
        run, moved = one.excitation, _moved(rig, one)
        reach = (f"{a:.2f}–{b:.2f}" for a, b in zip(moved.low, moved.high, strict=True))
        rows.append(
            (
                run.name,
                f"{run.start[0]:.2f}, {run.start[1]:.2f}",
                f"{run.duration:.2f}",
                *(() if at is None else (shown_width(rig, at, one.sigma[at]),)),
                plain(math.exp(one.gain), 3),
                plain(one.rate, 3),
                f"{np.max(np.abs(run.voltage)):.1f}" if run.knock == 0 else "knock",
                ", ".join(reach),
                f"{moved.speed:.2f}",
            )
        )
    header = (
        "run",
        "start x, y [m]",
        "time [s]",
        *(() if at is None else ("with it",)),
        "narrower by",
        "log a second [1/s]",
        "most [V]",
        "reach x, y [m]",
        "speed [m/s]",
    )
    reach = header.index("reach x, y [m]")
    return Table(title, header, tuple(rows), spare=((reach,), (reach + 1,)))


def shown_width(rig: Rig, index: int, sigma: float) -> str:
    """Half of a 95 % interval as it is printed.

    Args:
        rig: What is known of the rig.
        index: Number of the quantity.
        sigma: Its standard error as a fit holds it.

    Returns:
        "± 1.2 %", or in the quantity's unit where it is zero.
    """
    half, known = half_width(float(sigma), 0.95, math.inf), quantity(rig.names[index])
    held = abs(float(rig.point[index]))
    if known.positive or held > 0:
        return f"± {percent(half if known.positive else half / held)}"
    return f"± {half:.2g}{'' if known.unit == '1' else ' ' + known.unit}"


class _Moved(NamedTuple):
    """Where the end-effector goes."""

    low: Float[np.ndarray, "2"]
    high: Float[np.ndarray, "2"]
    speed: float


def _moved(rig: Rig, candidate: Candidate) -> _Moved:
    run = candidate.excitation
    planned = jax.tree.map(lambda leaf: leaf[0], stacked([run], len(run.voltage)))
    states = motion(rig, planned)
    place, speed = (np.asarray(pose(part)) for part in (states.position, states.velocity))
    return _Moved(place.min(axis=0), place.max(axis=0), float(np.max(np.abs(speed))))


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
        '"torque_step". Stop it by hand if it comes near the frame: the limits were kept by '
        "every robot that what is known allows for, not by one that the model doesn't hold.",
    )


def chosen_sentence(candidates: Sequence[Candidate]) -> str:
    """Whether the search by gradient was worth anything, in words.

    Args:
        candidates: The candidates, the best one first.

    Returns:
        A sentence.
    """
    best = candidates[0]
    ready = next(one for one in candidates if not one.excitation.designed)
    if not best.excitation.designed:
        return "The search by gradient found nothing better than the catalogue has."
    return (
        f"A second of the improved run narrows {plain(best.rate / ready.rate, 3)} times as "
        "much (in logarithms) as one of the catalogue's best, for robots not searched with."
    )


def voltage_table(candidate: Candidate) -> str:
    """A run as CSV at the rate of the logs, each row held until the next.

    Args:
        candidate: The run.

    Returns:
        The table; its last row is 0 V.
    """
    voltage = np.repeat(candidate.excitation.voltage, round(STEP * RATE), axis=0)
    voltage = np.concatenate([voltage, np.zeros((1, 2))])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("t [s]", "voltage_1 [V]", "voltage_2 [V]"))
    for number, (first, second) in enumerate(voltage):
        writer.writerow((f"{number / RATE:.3f}", f"{first:.6g}", f"{second:.6g}"))
    return text.getvalue()
