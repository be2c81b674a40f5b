"""Legs of a rigid rig of `leg_rigs`, logged, and a robot that isn't quite the rig's."""

import leg_rigs
import numpy as np

from identification.campaign import CameraStream, Campaign, DriveStream, Run
from scdpr_jax.command.controller import published_pd
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.refinement.logged_leg import LoggedLeg

NOISE = 1.9e-4, 2e-3
GAINS = tuple(
    float(own) for own in (published_pd().proportional_gain, published_pd().derivative_gain)
)
RIG = leg_rigs.draw_rig(3, elastic=False)
TRUE = exact(
    replace(
        consistent(),
        {
            "effective_pretension": RIG.pretension,
            "friction_coefficient": RIG.lower_friction,
            "upper_friction_coefficient": RIG.upper_friction,
            "drive_inertia": RIG.inertia,
            "drive_damping": RIG.damping,
            "drive_friction": 0.0,
            "effective_radius": leg_rigs.RADIUS,
            "torque_per_volt": 0.482,
        },
    )
)
OFF = replace(
    TRUE,
    {
        "effective_pretension": 0.99 * RIG.pretension,
        "upper_friction_coefficient": 1.05 * RIG.upper_friction,
        "torque_per_volt": 0.97 * 0.482,
    },
)


def driven(seed):
    """A plain leg of the rig: what it did, where it began, and what is random of its log."""
    random = np.random.default_rng(seed)
    (own,) = leg_rigs.random_legs(seed, 1)
    own = own._replace(tilt=random.uniform(-0.6, 0.6))
    reference = leg_rigs.pulleys(leg_rigs.plain_profile(own, 1e-3, own.time))
    start = leg_rigs.start_of(RIG, own)
    ran = leg_rigs.drive_leg(RIG, start, reference, gains=GAINS, duration=own.time + 1.2)
    return own, ran, random


def logged(seed, name="leg", every=1):
    """A plain leg of the rig, as encoders and a camera of thirty frames a second show it."""
    own, ran, random = driven(seed)
    frames = np.arange(0.01, ran.time[-1] - 0.01, 1 / 30)
    place, turn = NOISE
    seen = [np.interp(frames, ran.time, ran.position[:, k]) for k in (0, 1, 3)]
    noise = random.normal(size=(frames.size, 3)) * [place, turn, place]
    seen = np.stack(seen, axis=1) + noise
    seen[random.random(seen.shape) < 0.02] = np.nan
    (x, y), slope = own.start, own.tilt * min(RIG.lower_friction, RIG.upper_friction)
    return LoggedLeg(
        name=name,
        time=ran.time[::every],
        angle=np.round(ran.angle[::every] / leg_rigs.COUNT) * leg_rigs.COUNT,
        voltage=ran.voltage[::every],
        seen_time=frames,
        seen=seen,
        place=(float(x + random.normal(0, 1e-4)), float(y)),
        slope=float(slope + random.normal(0, 1e-4)),
        noise=NOISE,
    )


def campaign(seeds):
    """The same as runs of a campaign, each resting before it begins."""
    runs = []
    for number, seed in enumerate(seeds, 1):
        _, ran, random = driven(seed)
        rest = 300
        rows = np.maximum(np.arange(-rest, len(ran.time)), 0)
        time, before = 1e-3 * np.arange(len(rows)), np.arange(len(rows)) < rest
        frames = np.arange(0.01, time[-1] - 0.01, 1 / 30)
        seen = np.stack([np.interp(frames, time, own[rows]) for own in ran.position.T], axis=1)
        place, turn = NOISE
        seen += random.normal(size=seen.shape) * [place, turn, place, place, place]
        runs.append(
            Run(
                name=f"{number:04d}-leg",
                kind="manoeuvre",
                pretension=350.0,
                pretension_label="350 N",
                drive=DriveStream(
                    time=time,
                    voltage=np.where(before[:, None], 0.0, ran.voltage[rows]),
                    angle=np.round(ran.angle[rows] / leg_rigs.COUNT) * leg_rigs.COUNT,
                ),
                camera=CameraStream(time=frames, position=seen),
            )
        )
    return Campaign(name="legs", runs=tuple(runs), counts_per_rev=26624.0)
