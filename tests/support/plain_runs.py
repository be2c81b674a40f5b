"""Runs that no robot made: numbers of the right size, for what only carries them over."""

import numpy as np

from identification.campaign import CameraStream, Campaign, DriveStream, Knock, Run
from identification.campaign.types import encoder_resolution

COUNTS = 26624.0


def run(name, kind, random, rows=400):
    """A run of steps of voltage, of counts that follow, and of frames with some lost."""
    time = np.arange(rows) * 1e-3
    voltage = np.round(random.uniform(-8, 8, (rows // 50, 2)), 3).repeat(50, axis=0)
    counts = np.rint(np.cumsum(random.normal(0, 3, (rows, 2)), axis=0))
    frames = np.round(np.sort(random.uniform(0, time[-1], 13)), 6)
    place = np.round(random.uniform(0.3, 0.6, (13, 5)), 6)
    place[random.random((13, 5)) < 0.1] = np.nan
    return Run(
        name=name,
        kind=kind,
        pretension=350.0,
        pretension_label="350 N",
        drive=DriveStream(
            time=time, voltage=voltage, angle=counts * encoder_resolution(COUNTS)
        ),
        camera=None if kind == "motor_step" else CameraStream(time=frames, position=place),
        knock=Knock(start=0.1, duration=0.03) if kind == "pseudo_impulse" else None,
    )


def campaign(seed, kinds=("torque_step", "pseudo_impulse", "motor_step")):
    random = np.random.default_rng(seed)
    runs = tuple(run(f"{k:04d}-run", kind, random) for k, kind in enumerate(kinds))
    return Campaign(name="plain", runs=runs, counts_per_rev=COUNTS)
