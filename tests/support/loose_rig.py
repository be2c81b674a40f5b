"""A test rig of its own: elastic cables, backlash, stick-slip, and nothing of the engine.

Many runs at once, in plain NumPy: a semi-implicit Euler step of half a millisecond, and
friction as an impulse that stops a body or slows it, never turns it round.
"""

import dataclasses

import numpy as np

from identification.campaign import (
    CameraStream,
    Campaign,
    DriveStream,
    Initial,
    Knock,
    Run,
)
from identification.campaign.types import Sensors

WIDTH, HEIGHT = 2.224, 1.112
MASS, TURNING, CARRIAGE = 2.1, 2.52e-2, 1.2
ARM = 0.1405
RADIUS, TORQUE = 0.073, 0.482
INERTIA, DAMPING = 1.2734e-2, 0.2124
LIMIT = 10.0
PERIOD, SUBSTEPS = 1e-3, 2
ROWS = 5000
GAINS = 60.0, 2.4
"""PD on the pulleys' angles [V/rad, V s/rad]."""


@dataclasses.dataclass(frozen=True)
class Truth:
    """What a rig is made of."""

    pretension: float
    friction: float
    stribeck: float
    inertia: float
    damping: float
    motor_friction: float
    stiffness: float
    backlash: float


def draw_truth(random: np.random.Generator, *, elastic: bool) -> Truth:
    pretension = float(np.exp(random.uniform(np.log(70), np.log(160))))
    return Truth(
        pretension=pretension,
        friction=float(random.uniform(1.5, 3.3)),
        stribeck=float(random.uniform(0, 0.3)) if elastic else 0.0,
        inertia=INERTIA * random.uniform(0.85, 1.25),
        damping=DAMPING * random.uniform(0.85, 1.15),
        motor_friction=float(random.uniform(0.02, 0.15)) if elastic else 0.0,
        stiffness=float(random.uniform(1e4, 4e4)) if elastic else 1.5e5,
        backlash=float(random.uniform(0, 4e-4)) if elastic else 0.0,
    )


@dataclasses.dataclass(frozen=True, eq=False)
class Program:
    """What is done in one run."""

    kind: str
    rows: int
    pose: tuple[float, float] = (1.0, 0.5)
    volts: np.ndarray | None = None
    reference: np.ndarray | None = None
    push: np.ndarray | None = None


def programs(random: np.random.Generator) -> list[Program]:
    """Fourteen runs as the paper's rig does them."""
    time = np.arange(ROWS) * PERIOD
    on = ((time >= 0.1) & (time < 1.1))[:, None]
    runs = []
    size = random.uniform(0.7, 0.92)
    for pose, volts in (
        ((0.173, 0.300), (10.0, 10.0)),
        ((1.830, 0.300), (-9.9, -9.9)),
        ((0.550, 0.234), (3.9, -3.9)),
        ((0.550, 0.921), (-3.8, 3.8)),
    ):
        runs.append(Program("torque_step", 2700, pose, volts=size * np.array(volts) * on))
    for start, there in (((0.4, 0.55), (1.7, 0.55)), ((0.8, 0.3), (0.8, 0.8))):
        share = _there_and_back(time, random.uniform(1.5, 1.8))
        way = np.array(start) + share[:, None] * (np.array(there) - np.array(start))
        runs.append(Program("manoeuvre", 4600, start, reference=way))
    pushed = (time >= 0.3) & (time < 0.33)
    for pose, force, holds in (
        ((0.55, 0.55), 45.0, True),
        ((1.12, 0.55), -40.0, False),
        ((1.12, 0.86), 60.0, True),
        ((1.64, 0.24), 30.0, False),
    ):
        hold = np.tile(np.array(pose), (ROWS, 1)) if holds else None
        push = force * random.uniform(0.8, 1.2) * pushed
        runs.append(Program("pseudo_impulse", 3000, pose, reference=hold, push=push))
    stairs = np.repeat(0.1 * np.floor(time / 0.3)[:, None], 2, axis=1)
    runs += [Program("breakaway", 4600, (x, 0.545), volts=stairs) for x in (0.5, 1.6)]
    for volts in (4.0, -6.0):
        step = np.repeat(np.where(time >= 0.1, volts, 0.0)[:, None], 2, axis=1)
        runs.append(Program("motor_step", 1300, volts=step))
    return runs


def _there_and_back(time: np.ndarray, leg: float) -> np.ndarray:
    def smooth(share: np.ndarray) -> np.ndarray:
        u = np.clip(share, 0, 1)
        return u**3 * (10 - 15 * u + 6 * u**2)

    return smooth((time - 0.2) / leg) - smooth((time - 0.5 - leg) / leg)


@dataclasses.dataclass(frozen=True, eq=False)
class Motion:
    """What the runs did, one column a run."""

    position: np.ndarray  # rows, 5, runs: x, delta, q3, q4, y
    angle: np.ndarray  # rows, 2, runs
    voltage: np.ndarray  # rows, 2, runs


def simulate(truths: list[Truth], runs: list[Program], random: np.random.Generator) -> Motion:
    """All runs at once."""
    many, dt = len(runs), PERIOD / SUBSTEPS
    p = {
        f.name: np.array([getattr(t, f.name) for t in truths])
        for f in dataclasses.fields(Truth)
    }
    bare = np.array([run.kind == "motor_step" for run in runs])
    steps = np.array([run.kind == "breakaway" for run in runs])
    closed = np.array([run.reference is not None for run in runs])
    volts = np.stack([np.zeros((ROWS, 2)) if r.volts is None else r.volts for r in runs], -1)
    ways = np.stack(
        [np.zeros((ROWS, 2)) if r.reference is None else r.reference for r in runs], -1
    )
    pushes = np.stack([np.zeros(ROWS) if r.push is None else r.push for r in runs], -1)
    stiffness = np.where(bare, 0.0, p["stiffness"])
    slack = np.where(bare, 0.0, 60.0)

    x, y = np.array([run.pose for run in runs]).T + random.normal(0, 5e-4, (2, many))
    lean = random.uniform(-0.8, 0.8, many) * p["friction"] / (2 * p["pretension"])
    q = np.stack([x, np.arctan(lean), x + lean * y, x + lean * (y - HEIGHT), y])
    v, a, w = np.zeros((5, many)), np.zeros((2, many)), np.zeros((2, many))
    start = q.copy()
    stopped = np.zeros(many, dtype=bool)
    held = np.array([CARRIAGE, CARRIAGE])[:, None]
    positions, angles, commands = (np.empty((ROWS, n, many)) for n in (5, 2, 2))
    begin = ways[0]
    count = 2 * np.pi / 26624
    seen_before = np.zeros((2, many))
    for row in range(ROWS):
        positions[row], angles[row] = q, a
        stopped |= steps & (np.abs(q[2] - start[2]) > 0.06)
        along, up = ways[row] - begin
        wanted = np.stack([along + up, along - up]) / RADIUS
        seen = np.round(a / count) * count
        rate = (seen - seen_before) / PERIOD
        seen_before = seen
        target = (ways[min(row + 1, ROWS - 1)] - ways[row]) / PERIOD
        wished = np.stack([target[0] + target[1], target[0] - target[1]]) / RADIUS
        control = GAINS[0] * (wanted - seen) + GAINS[1] * (wished - rate)
        command = np.where(closed, control, np.where(stopped, 0.0, volts[row]))
        command = np.clip(command, -LIMIT, LIMIT)
        commands[row] = command
        for _ in range(SUBSTEPS):
            sine, cosine = np.sin(q[1]), np.cos(q[1])
            low = q[0] + ARM * sine - q[2], q[4] - ARM * cosine
            top = q[0] - ARM * sine - q[3], q[4] + ARM * cosine - HEIGHT
            pull = -2 * p["pretension"] / np.hypot(*low)
            lift = -2 * p["pretension"] / np.hypot(*top)
            cable = RADIUS * a - np.stack(
                [q[2] - start[2] + q[4] - start[4], q[2] - start[2] - q[4] + start[4]]
            )
            stretch = cable - np.clip(cable, -p["backlash"] / 2, p["backlash"] / 2)
            give = RADIUS * w - np.stack([v[2] + v[4], v[2] - v[4]])
            force = stiffness * stretch + slack * give
            fx, fy = pull * low[0] + lift * top[0], pull * low[1] + lift * top[1]
            torque = pull * (ARM * sine * low[1] + ARM * cosine * low[0]) + lift * (
                -ARM * sine * top[1] - ARM * cosine * top[0]
            )
            v = v + dt * np.stack(
                [
                    (fx + pushes[row] - 0.8 * v[0]) / MASS,
                    (torque - 0.05 * v[1]) / TURNING,
                    (force[0] + force[1] - pull * low[0]) / CARRIAGE,
                    -lift * top[0] / CARRIAGE,
                    (force[0] - force[1] + fy) / MASS,
                ]
            )
            speed = np.abs(v[2:4])
            dry = p["friction"] * (1 + p["stribeck"] * np.exp(-speed / 0.02)) * dt / held
            v[2:4] = np.sign(v[2:4]) * np.maximum(speed - dry, 0)
            w = w + dt * (TORQUE * command - p["damping"] * w - RADIUS * force) / p["inertia"]
            dry = p["motor_friction"] * dt / p["inertia"]
            w = np.sign(w) * np.maximum(np.abs(w) - dry, 0)
            q, a = q + dt * v, a + dt * w
    return Motion(positions, angles, commands)


def campaigns(seeds: list[int], *, elastic: bool | None = None) -> list[Campaign]:
    """One campaign a seed, each of its own rig, its own sensors and its own habits."""
    randoms = [np.random.default_rng(seed) for seed in seeds]
    drawn = [
        draw_truth(random, elastic=random.random() < 0.4 if elastic is None else elastic)
        for random in randoms
    ]
    plans = [programs(random) for random in randoms]
    truths = [truth for truth, plan in zip(drawn, plans, strict=True) for _ in plan]
    motion = simulate(truths, [run for plan in plans for run in plan], randoms[0])
    found, first = [], 0
    for random, plan, seed in zip(randoms, plans, seeds, strict=True):
        part = slice(first, first + len(plan))
        found.append(logged(random, plan, motion, part, seed, _habits(random)))
        first += len(plan)
    return found


def _habits(random: np.random.Generator) -> "Habits":
    counts = float(random.choice([26624, 26624, 8192, 65536, 40000]))
    clock = random.choice(["zero", "stated", "unknown"], p=[0.75, 0.15, 0.1])
    offset = {"zero": 0.0, "stated": 0.012, "unknown": float(random.uniform(-0.03, 0.03))}[
        clock
    ]
    return Habits(
        counts=counts,
        offset=offset,
        stated=None if clock == "unknown" else offset,
        knocks=random.random() > 0.1,
        initial=random.random() > 0.2,
        every=int(random.choice([1, 1, 1, 2, 4])),
        lost=float(random.choice([0.0, 0.003, 0.02])),
    )


def logged(
    random: np.random.Generator,
    plan: list[Program],
    motion: Motion,
    part: slice,
    seed: int,
    habits: "Habits",
) -> Campaign:
    """The campaign that sensors with such habits make of the runs in some columns."""
    runs = []
    for number, (program, column) in enumerate(
        zip(plan, range(part.start, part.stop), strict=True)
    ):
        runs.append(_run(random, number, program, motion, column, habits))
    return Campaign(
        name=f"loose rig, seed {seed}",
        runs=tuple(runs),
        counts_per_rev=habits.counts,
        robot={"effective_radius": RADIUS},
        sensors=Sensors(encoder_sigma=float(2 * np.pi / habits.counts / np.sqrt(12))),
    )


@dataclasses.dataclass(frozen=True)
class Habits:
    """What a lab's sensors and its people are like."""

    counts: float
    offset: float
    stated: float | None
    knocks: bool
    initial: bool
    every: int
    lost: float


def _run(
    random: np.random.Generator,
    number: int,
    program: Program,
    motion: Motion,
    column: int,
    habits: Habits,
) -> Run:
    rows, count = program.rows, 2 * np.pi / habits.counts
    time = np.arange(rows) * PERIOD
    angle = np.round(motion.angle[:rows, :, column] / count) * count
    knock = program.push is not None and habits.knocks
    camera = None
    if program.kind != "motor_step":
        stamps = random.uniform(2e-3, 30e-3) + np.arange(int(rows * PERIOD * 30) - 1) / 30
        stamps = stamps + random.uniform(-5e-4, 5e-4, len(stamps))
        stamps = stamps[stamps < time[-1]]
        noise = np.array([1.9e-4, 2e-3, 1.9e-4, 1.9e-4, 1.9e-4])
        seen = np.stack(
            [np.interp(stamps, time, motion.position[:rows, k, column]) for k in range(5)], 1
        )
        seen = seen + noise * random.normal(size=seen.shape)
        seen[random.random(seen.shape) < habits.lost] = np.nan
        camera = CameraStream(time=stamps + habits.offset, position=seen)
    return Run(
        name=f"{number + 1:04d}-{program.kind.replace('_', '-')}",
        kind=program.kind,
        pretension=350.0,
        pretension_label="350 N",
        drive=DriveStream(
            time=time[:: habits.every],
            voltage=np.round(motion.voltage[:rows, :, column], 3)[:: habits.every],
            angle=angle[:: habits.every],
        ),
        camera=camera,
        initial=Initial(x_e=program.pose[0], y_e=program.pose[1])
        if habits.initial and camera is not None
        else None,
        knock=Knock(start=0.3, duration=0.03) if knock else None,
        clock_offset=habits.stated if camera is not None else 0.0,
    )
