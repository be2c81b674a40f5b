"""Logs of runs that were planned, and what is known of a rig after a short, poor campaign."""

import dataclasses

import jax.numpy as jnp
import numpy as np

from experiments.virtual_rig.recovery import SETTING, draw, simulated
from identification.campaign import CameraStream, Campaign, DriveStream, Knock, Run
from identification.campaign.types import default_sensors, encoder_resolution
from identification.fit.unknowns.options import FitOptions
from identification.fit.unknowns.unknowns import apply, encode
from identification.next_run.excitation import KNOCK_TIME, REST, STEP, Excitation
from identification.next_run.expected_information import Rig, rig_errors
from identification.result.estimation import estimate
from scdpr_jax.robot.quantities import quantity, replace, value

PERIOD, SUBSTEPS = 1e-3, 2
COUNTS = 2000.0
COUNT = encoder_resolution(COUNTS)
SENSORS = dataclasses.replace(
    default_sensors(COUNTS), camera_position_sigma=2e-3, camera_angle_sigma=2e-2
)
"""Ten times as coarse as the paper's rig."""

SHORT = np.zeros((80, 2))
SHORT[20:50] = [2.4, 2.3]
POOR = Excitation("a short push", (0.8, 0.5), SHORT)


def drawn(seed):
    """A drawn robot, its drives with dry friction."""
    friction = np.random.default_rng(seed).uniform(0.05, 0.3)
    return replace(draw(seed).robot, {"drive_friction": float(friction)})


def logged(robot, excitation, seed, name="0002-planned"):
    """The log of a planned run: out of line, off its start, rounded, noisy."""
    random = np.random.default_rng(seed)
    volts = np.repeat(excitation.voltage, round(STEP / PERIOD), axis=0)
    time = PERIOD * np.arange(len(volts) + 1)
    pushed = (time[:-1] > REST - PERIOD / 2) & (time[:-1] < REST + KNOCK_TIME - PERIOD / 2)
    stamps = random.uniform(2e-3, 30e-3) + np.arange(int(time[-1] * 30) - 1) / 30
    slope = random.uniform(-0.3, 0.3) * float(value(robot, "friction_coefficient"))
    x, y = np.array(excitation.start) + random.normal(0, 5e-4, 2)
    lower = x + slope * y
    angle, frame = simulated(
        robot,
        jnp.array([lower, lower - slope * float(robot.frame.height), y]),
        jnp.asarray(volts),
        jnp.asarray(np.where(pushed, excitation.knock * random.normal(1, 0.2), 0.0)),
        jnp.asarray(stamps),
        period=PERIOD,
        substeps=SUBSTEPS,
    )
    sigma = np.full(5, SENSORS.camera_position_sigma)
    sigma[1] = SENSORS.camera_angle_sigma
    read = np.asarray(angle) + random.uniform(0, COUNT, 2)
    return Run(
        name=name,
        kind="pseudo_impulse" if excitation.knock else "torque_step",
        pretension=350.0,
        pretension_label=SETTING,
        drive=DriveStream(
            time=time,
            voltage=np.concatenate([volts, np.zeros((1, 2))]),
            angle=np.round(read / COUNT) * COUNT,
        ),
        camera=CameraStream(
            time=stamps, position=np.asarray(frame) + sigma * random.normal(size=frame.shape)
        ),
        knock=Knock(start=REST, duration=KNOCK_TIME) if excitation.knock else None,
    )


def campaign(robot, *runs):
    known = {"effective_radius": float(value(robot, "effective_radius"))}
    return Campaign(
        name="planned", runs=runs, counts_per_rev=COUNTS, robot=known, sensors=SENSORS
    )


def rig_after(found):
    """What a fit knows, as the design takes it."""
    rows = [p for p in found.parameters if p.status != "fixed"]
    at = [k for k, p in enumerate(rows) if p.status != "at_bound"]
    sigma = np.array([_held(rows[k].name, rows[k].sigma, rows[k].value) for k in at])
    covariance = found.correlation[np.ix_(at, at)] * np.outer(sigma, sigma)
    return Rig(
        robot=found.of_setting(SETTING),
        names=tuple(rows[k].name for k in at),
        point=np.array([encode(rows[k].name, rows[k].value) for k in at]),
        root=np.linalg.cholesky(covariance),
        count=COUNT,
        log_rate=1 / PERIOD,
        top_speed=1.5,
        **rig_errors(SENSORS),
    )


def _held(name, sigma, number):
    return sigma / number if quantity(name).positive else sigma


def errors(rig, found, start, excitation, truths, *, seed):
    """Errors of fits with a run added, one row for each robot that may be the true one."""
    rows = []
    for number, truth in enumerate(np.asarray(truths)):
        robot = apply(rig.robot, rig.names, jnp.asarray(truth))
        run = logged(robot, excitation, [seed, number])
        fitted = estimate(campaign(robot, start, run), FitOptions(robot=found.robot))
        values = {p.name: p.value for p in fitted.parameters}
        # A quantity at its bound of zero is off by what it should be.
        held = [encode(n, values[n]) for n in rig.names]
        rows.append(np.array(held) - truth)
    return np.array(rows)
