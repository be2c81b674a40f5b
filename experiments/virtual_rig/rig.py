"""A virtual rig: a campaign of logged runs of a robot whose truth is known.

It does what the paper's rig does (the torque steps of Table 2, manoeuvres of Table 3, knocks,
breakaway staircases, steps of the bare drives) with exact friction on a grid four times as
fine as its log's, rounds its encoders to counts, and adds the camera's noise.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from experiments.virtual_rig.simulated import (
    COUNTS_PER_REV,
    PERIOD,
    ROWS,
    Simulated,
    closed_loop,
    film,
    open_loop,
)
from identification.axis.motion import AxisParameters, axis_positions
from identification.campaign import (
    CameraStream,
    Campaign,
    DriveStream,
    Initial,
    Knock,
    Run,
)
from identification.campaign.types import default_sensors, encoder_resolution
from scdpr_jax.command.trajectory import table_3
from scdpr_jax.legs.starts import rest_out_of_line
from scdpr_jax.numerics.progress import SILENT, Progress
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import State

SETTING = "350 N"
"""Nominal pretension of every run."""

TORQUE_STEPS = (
    ((0.173, 0.300), (4.85, 4.85)),
    ((1.830, 0.300), (-4.78, -4.78)),
    ((0.550, 0.234), (1.87, -1.87)),
    ((0.550, 0.921), (-1.82, 1.82)),
)
"""Start [m] and torques [N m] of Table 2's experiments, one second each."""

KNOCKS = (
    ((0.55, 0.55), 45.0, True),
    ((1.12, 0.55), -40.0, False),
    ((1.12, 0.86), 60.0, True),
    ((1.64, 0.24), 30.0, False),
)
"""Pose [m], force [N] and whether the drives hold the pose, of each knock."""


DEMONSTRATED = (
    "0001-torque-step",
    "0003-torque-step",
    "0005-manoeuvre",
    "0008-pseudo-impulse",
    "0009-pseudo-impulse",
    "0010-pseudo-impulse",
    "0013-motor-step",
    "0014-motor-step",
)
"""Runs that `scdpr demo` makes do with: enough for every parameter, in half the time."""


class Truth(NamedTuple):
    """What the virtual rig knows and the fit has to find."""

    robot: Robot
    """The rig's robot."""
    values: dict[str, float]
    """The quantities to be found, by name [SI]."""


def draw_truth(seed: int) -> Truth:
    """A robot that differs from the consistent prototype by as much as rigs do.

    Args:
        seed: Seed of the random draw.

    Returns:
        Its true parameters.
    """
    random = np.random.default_rng(seed)
    prototype = consistent()
    pretension = float(np.exp(random.uniform(np.log(70), np.log(160))))
    friction_force = float(random.uniform(3.5, 6.5))
    values = {
        "friction_coefficient": friction_force / (4 * pretension),
        "drive_inertia": float(value(prototype, "drive_inertia")) * random.uniform(0.88, 1.15),
        "drive_damping": float(value(prototype, "drive_damping")) * random.uniform(0.9, 1.1),
        "effective_pretension": pretension,
    }
    return Truth(replace(prototype, values), values)


def campaign(
    truth: Truth,
    seed: int,
    *,
    progress: Progress = SILENT,
) -> Campaign:
    """Fourteen runs of the virtual rig.

    Args:
        truth: The rig's robot.
        seed: Seed of start poses, camera jitter and noise.
        progress: Told what is being done and which share of it is done.

    Returns:
        The campaign as a reader of its logs would see it.
    """
    rig = _Rig(truth.robot, np.random.default_rng(seed), jax.random.key(seed))
    runs: list[Run] = []

    def add(kind: str, logged: "_Logged", **told: object) -> None:
        name = f"{len(runs) + 1:04d}-{kind.replace('_', '-')}"
        runs.append(
            Run(
                name=name,
                kind=kind,
                pretension=float(SETTING.split()[0]),
                pretension_label=SETTING,
                drive=logged.drive,
                camera=logged.camera,
                **told,
            )
        )
        progress(f"virtual rig, {name}", len(runs) / 14)

    for number, (pose, torque) in enumerate(TORQUE_STEPS):
        notes = f"experiment {number + 1} of Table 2"
        logged, scale = rig.torque_step(pose, torque)
        if scale < 1:
            notes += f", torque scaled to {scale:.0%} to stay inside the frame"
        add("torque_step", logged, notes=notes, initial=Initial(x_e=pose[0], y_e=pose[1]))
    manoeuvres = table_3(start_time=0.2, leg_times=(2.0, 2.25, 2.5))
    for label in ("horizontal", "vertical"):
        reference = getattr(manoeuvres, label)
        x, y = (float(part) for part in reference.position(jnp.asarray(0.0)))
        add(
            "manoeuvre",
            rig.manoeuvre(reference),
            notes=f"{label} manoeuvre of Table 3",
            initial=Initial(x_e=x, y_e=y),
        )
    for pose, force, held in KNOCKS:
        notes = "drives hold the pose" if held else "drives at zero volts"
        add(
            "pseudo_impulse",
            rig.knock(pose, force, held=held),
            notes=f"horizontal knock on the end-effector; {notes}",
            knock=Knock(start=0.3, duration=0.03),
        )
    for x in (0.5, 1.6):
        add("breakaway", rig.breakaway((x, 0.545)), notes="staircase of 0.1 V every 0.3 s")
    for volts in (4.0, -6.0):
        add("motor_step", rig.motor_step(volts), notes="bare drives, cable off the pulleys")
    return Campaign(
        name=f"virtual rig, seed {seed}",
        runs=tuple(runs),
        counts_per_rev=COUNTS_PER_REV,
        robot={"effective_radius": float(value(truth.robot, "effective_radius"))},
        sensors=default_sensors(COUNTS_PER_REV),
    )


class _Logged(NamedTuple):
    drive: DriveStream
    camera: CameraStream | None


class _Rig:
    """The robot with its sensors; every run draws its own start and noise."""

    def __init__(self, robot: Robot, random: np.random.Generator, key: Array) -> None:
        self.robot = robot
        self.random = random
        self.key = key

    def torque_step(
        self, pose: tuple[float, float], torque: tuple[float, float]
    ) -> tuple[_Logged, float]:
        """One second of torque and 1.6 s of coasting, weaker if it would leave the frame."""
        start, scale = self.start(pose), 1.0
        drive = self.robot.drive
        limit = float(drive.voltage_limit)
        volts = np.clip(np.array(torque) / float(drive.torque_per_volt), -limit, limit)
        time = np.arange(2700) * PERIOD
        on = (time >= 0.1) & (time < 1.1)
        while True:
            voltage = np.round(scale * volts, 3) * on[:, None]
            run = open_loop(self.robot, start, voltage)
            if self.inside(run.states) or scale < 0.5:
                return self.log(run, voltage), scale
            scale -= 0.03

    def inside(self, states: State) -> bool:
        """Whether the robot stays clear of the frame by 5 cm."""
        q, frame = np.asarray(states.position), self.robot.frame
        wide = (
            q[:, [0, 2, 3]].min() > 0.05 and q[:, [0, 2, 3]].max() < float(frame.width) - 0.05
        )
        low, high = map(float, self.robot.heights)
        return bool(wide and q[:, 4].min() > low + 0.05 and q[:, 4].max() < high - 0.05)

    def manoeuvre(self, trajectory: eqx.Module) -> _Logged:
        """A manoeuvre under the paper's PD, with a rest before and after."""
        rows = round((float(trajectory.duration) + 0.6) / PERIOD)
        reference = np.asarray(jax.vmap(trajectory.position)(PERIOD * jnp.arange(float(ROWS))))
        x, y = (float(part) for part in reference[0])
        return self.under_control(self.start((x, y)), reference, np.zeros(ROWS), rows)

    def knock(self, pose: tuple[float, float], force: float, *, held: bool) -> _Logged:
        """A push of 30 ms on the end-effector, the drives holding or at zero volts."""
        start = self.start(pose)
        time = np.arange(ROWS) * PERIOD
        pushed = np.where((time >= 0.3) & (time < 0.33), force, 0.0)
        if held:
            where = np.asarray(start.pose)
            return self.under_control(start, np.tile(where, (ROWS, 1)), pushed, 3000)
        voltage = np.zeros((3000, 2))
        return self.log(open_loop(self.robot, start, voltage, pushed), voltage)

    def under_control(
        self,
        start: State,
        reference: Float[np.ndarray, "rows 2"],
        knock: Float[np.ndarray, " rows"],
        rows: int,
    ) -> _Logged:
        """A run under the paper's PD."""
        run = closed_loop(self.robot, start, jnp.asarray(reference), jnp.asarray(knock[:-1]))
        return self.log(run, np.asarray(run.voltage)[:rows], reference[:rows])

    def breakaway(self, pose: tuple[float, float]) -> _Logged:
        """A staircase on both motors until the drives have moved 60 mm, then zero volts."""
        start = self.start(pose)
        time = np.arange(ROWS) * PERIOD
        stairs = np.round(0.1 * np.floor(time / 0.3), 3)
        voltage = np.stack([stairs, stairs], axis=1)
        lower = np.asarray(open_loop(self.robot, start, voltage).states.position)[:, 2]
        moved = np.abs(lower - lower[0]) > 0.06
        there = int(np.argmax(moved)) if np.any(moved) else ROWS - 1
        voltage[there:] = 0.0
        run = open_loop(self.robot, start, voltage)
        return self.log(run, voltage[: there + 1000])

    def motor_step(self, volts: float) -> _Logged:
        """A speed step of the bare drives."""
        time = np.arange(1300) * PERIOD
        voltage = np.where(time >= 0.1, volts, 0.0)
        drive = self.robot.drive
        torque = motor_torque(drive, jnp.asarray(voltage[:-1]))
        steps, still = jnp.full(time.size - 1, PERIOD), jnp.zeros(())
        axes = [AxisParameters(drive.inertia, drive.damping, f, 0.0) for f in drive.frictions]
        angle = np.stack(
            [axis_positions(axis, torque, steps=steps, start=still) for axis in axes], axis=1
        )
        both = np.repeat(voltage[:, None], 2, axis=1)
        return _Logged(self.drive(time, both, angle, None), None)

    def start(self, pose: tuple[float, float]) -> State:
        """At rest near a pose, the carriages held out of line by friction."""
        x, y = np.array(pose) + self.random.normal(0, 5e-4, 2)
        share = jnp.asarray(self.random.uniform(-0.8, 0.8))
        return rest_out_of_line(self.robot, jnp.asarray([x, y]), share)

    def drive(
        self,
        time: Float[np.ndarray, " rows"],
        voltage: Float[np.ndarray, "rows 2"],
        angle: Float[np.ndarray, "rows 2"],
        reference: Float[np.ndarray, "rows 2"] | None,
    ) -> DriveStream:
        """The controller's stream, the angles rounded to counts."""
        count = encoder_resolution(COUNTS_PER_REV)
        return DriveStream(
            time=time,
            voltage=voltage,
            angle=np.round(angle / count) * count,
            reference=reference,
        )

    def log(
        self,
        run: Simulated,
        voltage: Float[np.ndarray, "rows 2"],
        reference: Float[np.ndarray, "rows 2"] | None = None,
    ) -> _Logged:
        """What the rig writes of a run, as long as its commands."""
        rows = voltage.shape[0]
        time = np.arange(rows) * PERIOD
        drive = self.drive(time, voltage, np.asarray(run.angle)[:rows], reference)
        self.key, key = jax.random.split(self.key)
        first = jnp.asarray(self.random.uniform(2e-3, 30e-3))
        stamps, seen = (np.asarray(part) for part in film(run.states, first, key))
        inside = stamps < time[-1]
        return _Logged(drive, CameraStream(time=stamps[inside], position=seen[inside]))
