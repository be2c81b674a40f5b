"""Test rigs that drive legs: another program, integrated finely, none of the engine's code.

Two classes, drawn by seed: rigid rigs, of the model's own class, and elastic ones, with a cable
that stretches between drive and carriage, backlash, torque ripple, Stribeck friction, friction
of the motors, and a loop whose tension grows with its length. `leg_rig.c` beside this holds
their equations; what uses it is skipped where there is no C compiler.
"""

import ctypes
import dataclasses
import functools
import math
import pathlib
import shutil
import subprocess
import tempfile
from typing import NamedTuple

import loose_rig
import numpy as np
import pytest

from identification.campaign import Campaign

HEIGHT, RADIUS = loose_rig.HEIGHT, loose_rig.RADIUS
COUNT = 2 * np.pi / 26624
"""Resolution of the encoders [rad]."""
STEP = 25e-6
"""Step of the integration [s]: forty in a period of 1 kHz."""
HOLD = 1.0
"""Time after a leg that is looked at [s]."""
SOURCE = pathlib.Path(__file__).with_name("leg_rig.c")

needs_compiler = pytest.mark.skipif(
    shutil.which("cc") is None, reason="there is no C compiler, `cc`, to build the rigs with"
)


@dataclasses.dataclass(frozen=True)
class Rig:
    """What a rig is made of, in SI units; the same order as in `leg_rig.c`."""

    pretension: float
    loop_stiffness: float
    lower_friction: float
    upper_friction: float
    static_surplus: float
    inertia: float
    damping: float
    motor_friction: float
    cable_stiffness: float
    cable_damping: float
    backlash: float
    ripple: float
    ripple_waves: float
    air_damping: float
    turning_damping: float

    @property
    def rigid(self) -> bool:
        """Whether the drives hold the carriage without give."""
        return math.isinf(self.cable_stiffness)


class RandomLeg(NamedTuple):
    """A leg from rest to rest, and how its start is out of line."""

    start: tuple[float, float]
    end: tuple[float, float]
    time: float
    tilt: float
    """Slope of the line between the carriages over what friction holds [1]; 0 in line."""


class Driven(NamedTuple):
    """What a rig did, one row a period."""

    time: np.ndarray
    position: np.ndarray  # rows, 5: x_e, delta, q3, q4, y
    angle: np.ndarray  # rows, 2
    voltage: np.ndarray  # rows, 2

    def vibration(self, since: float) -> float:
        """Peak to peak of x_e from a time on [m]."""
        return float(np.ptp(self.position[self.time >= since, 0]))

    def resting_error(self, end: tuple[float, float]) -> float:
        """Distance from a target to where the end-effector rests between the carriages [m]."""
        _, _, lower, upper, y = self.position[-1]
        return math.hypot(lower + (upper - lower) * y / HEIGHT - end[0], y - end[1])


def draw_rig(seed: int, *, elastic: bool) -> Rig:
    """A rig of either class, as far from the paper's as rigs are."""
    random = np.random.default_rng([seed, int(elastic)])
    pretension = float(np.exp(random.uniform(np.log(70), np.log(160))))
    friction = random.uniform(3.5, 6.5) / (4 * pretension)
    drive = {
        "pretension": pretension,
        "lower_friction": friction,
        "upper_friction": friction * (random.uniform(0.9, 1.1) if elastic else 1.0),
        "inertia": loose_rig.INERTIA * random.uniform(0.88, 1.15),
        "damping": loose_rig.DAMPING * random.uniform(0.9, 1.1),
    }
    if elastic:
        give = {
            "loop_stiffness": random.uniform(0, 1000),
            "static_surplus": random.uniform(0, 0.3),
            "motor_friction": random.uniform(0.02, 0.1),
            "cable_stiffness": random.uniform(1.5e4, 4e4),
            "cable_damping": 60.0,
            "backlash": random.uniform(0, 3e-4),
            "ripple": random.uniform(0, 0.03),
            "ripple_waves": float(random.integers(20, 60)),
            "air_damping": random.uniform(0, 0.5),
            "turning_damping": 0.01,
        }
        return Rig(**drive, **{name: float(number) for name, number in give.items()})
    names = [field.name for field in dataclasses.fields(Rig) if field.name not in drive]
    return Rig(**drive, **{**dict.fromkeys(names, 0.0), "cable_stiffness": math.inf})


def random_legs(seed: int, count: int) -> list[RandomLeg]:
    """Legs over the workspace; every other one starts out of line."""
    random = np.random.default_rng(seed)
    legs: list[RandomLeg] = []
    while len(legs) < count:
        (x, there), (y, up) = random.uniform(0.3, 1.9, 2), random.uniform(0.25, 0.85, 2)
        time, tilt = random.uniform(1.7, 4.0), random.uniform(-0.8, 0.8)
        if abs(there - x) >= 0.3:
            own = float(tilt) if len(legs) % 2 else 0.0
            legs.append(
                RandomLeg((float(x), float(y)), (float(there), float(up)), float(time), own)
            )
    return legs


def start_of(rig: Rig, leg: RandomLeg) -> np.ndarray:
    """The rig at rest where a leg begins: x_e, delta, q3, q4, y."""
    (x, y), slope = leg.start, leg.tilt * min(rig.lower_friction, rig.upper_friction)
    return np.array([x, math.atan(slope), x + slope * y, x + slope * (y - HEIGHT), y])


def plain_profile(leg: RandomLeg, period: float, duration: float) -> np.ndarray:
    """The profile of Eq. (26), held after the leg: rows of [x, y] [m]."""
    share = np.clip(period * np.arange(round(duration / period) + 1) / leg.time, 0, 1)
    smooth = share**2 * (3 - 2 * share)
    return np.array(leg.start) + smooth[:, None] * (np.array(leg.end) - np.array(leg.start))


def shaped_profile(
    leg: RandomLeg, times: np.ndarray, amplitudes: np.ndarray, period: float = 1e-3
) -> np.ndarray:
    """The profile of Eq. (26) convolved with impulses, until it ends: rows of [x, y] [m]."""
    times, amplitudes = np.asarray(times), np.asarray(amplitudes)
    instants = period * np.arange(round((leg.time + times[-1]) / period) + 1)
    share = np.clip((instants[:, None] - times) / leg.time, 0, 1)
    smooth = (share**2 * (3 - 2 * share)) @ amplitudes
    return np.array(leg.start) + smooth[:, None] * (np.array(leg.end) - np.array(leg.start))


def pulleys(places: np.ndarray) -> np.ndarray:
    """Reference angles of the driver pulleys for places of the end-effector [rad], Eq. (3)."""
    along, up = (places - places[0]).T
    return np.stack([along + up, along - up], axis=1) / RADIUS


def drive_leg(
    rig: Rig,
    start: np.ndarray,
    reference: np.ndarray,
    feedforward: np.ndarray | None = None,
    *,
    gains: tuple[float, float],
    period: float = 1e-3,
    duration: float,
    push: np.ndarray | None = None,
    stop_after: float = 0.0,
    bare: bool = False,
) -> Driven:
    """A rig under reference angles [rad], feed-forward [V] and PD; the last row is held."""
    rows = round(duration / period) + 1

    def held(table: np.ndarray | None, shape: tuple[int, ...]) -> np.ndarray:
        if table is None:
            return np.zeros(shape)
        index = np.minimum(np.arange(rows), len(table) - 1)
        return np.ascontiguousarray(np.asarray(table, dtype=float)[index])

    given = held(reference, (rows, 2)), held(feedforward, (rows, 2)), held(push, (rows,))
    numbers = np.array(dataclasses.astuple(rig))
    loop = np.array([*gains, period, COUNT, stop_after, float(rig.rigid), float(bare)])
    result = np.empty((rows, 5)), np.empty((rows, 2)), np.empty((rows, 2))
    _library()(
        numbers,
        loop,
        rows,
        round(period / STEP),
        np.ascontiguousarray(start, dtype=float),
        *given,
        *result,
    )
    return Driven(period * np.arange(rows), *result)


def campaign(rig: Rig, seed: int) -> Campaign:
    """Fourteen runs of a rig, logged as it is: `loose_rig`'s programme and sensors."""
    random = np.random.default_rng([seed, 1])
    plan = loose_rig.programs(random)
    driven = [_programmed(rig, program, random) for program in plan]
    motion = loose_rig.Motion(
        *(np.stack([run[part] for run in driven], axis=-1) for part in (1, 2, 3))
    )
    habits = loose_rig.Habits(
        counts=26624.0, offset=0.0, stated=0.0, knocks=True, initial=True, every=1, lost=0.0
    )
    return loose_rig.logged(random, plan, motion, slice(0, len(plan)), seed, habits)


def _programmed(rig: Rig, program: loose_rig.Program, random: np.random.Generator) -> Driven:
    """A run of `loose_rig`'s programme, a little off its pose and out of line."""
    x, y = np.array(program.pose) + random.normal(0, 5e-4, 2)
    leg = RandomLeg((x, y), (x, y), 1.0, random.uniform(-0.8, 0.8))
    closed = program.reference is not None
    rows = loose_rig.ROWS
    volts = np.zeros((rows, 2)) if program.volts is None else program.volts
    wanted = pulleys(program.reference) if closed else np.zeros((rows, 2))
    return drive_leg(
        rig,
        start_of(rig, leg),
        wanted,
        volts,
        gains=loose_rig.GAINS if closed else (0.0, 0.0),
        duration=(rows - 1) * loose_rig.PERIOD,
        push=program.push,
        stop_after=0.06 if program.kind == "breakaway" else 0.0,
        bare=program.kind == "motor_step",
    )


@functools.cache
def _library() -> ctypes._CFuncPtr:
    """The rigs' program, built once a process."""
    with tempfile.TemporaryDirectory() as folder:
        built = pathlib.Path(folder) / "leg_rig.so"
        command = ["cc", "-std=c99", "-O3", "-shared", "-fPIC", "-o", built, SOURCE, "-lm"]
        subprocess.run(command, check=True)
        run = ctypes.CDLL(str(built)).rig_run
    table = np.ctypeslib.ndpointer(dtype=float, flags="C_CONTIGUOUS")
    run.argtypes = [table, table, ctypes.c_int, ctypes.c_int, *[table] * 7]
    run.restype = None
    return run
