"""One recording of many knocks, and the same knocks as if each had been logged by itself."""

import dataclasses

import numpy as np

from identification.campaign import CameraStream, Campaign, DriveStream, Knock, Run
from identification.campaign.types import encoder_resolution

COUNTS = 26624.0
COUNT = encoder_resolution(COUNTS)


@dataclasses.dataclass(frozen=True)
class Recording:
    """A recording and its knocks."""

    whole: Run
    """The recording as one run."""
    single: Campaign
    """Its knocks, logged one by one."""
    frequency: np.ndarray
    """Frequency of each [Hz]."""


def recording(seed, knocks=40, rate=1000.0, frames=30.0):
    """Knocks at random times, poses that the operator moves to by hand, decays to rest."""
    random = np.random.default_rng(seed)
    frequency, ratio = random.uniform(2.2, 4.2, knocks), random.uniform(0.012, 0.03, knocks)
    size = random.uniform(6e-3, 30e-3, knocks) * random.choice([-1, 1], knocks)
    # Until a tenth of a millimetre is left, and some rest before the next one.
    decay = 2 * np.pi * frequency * ratio
    lasts = np.log(np.abs(size) / 1e-4) / decay + random.uniform(0.6, 3.0, knocks)
    start = 0.8 + np.concatenate([[0.0], np.cumsum(lasts)[:-1]])
    time = np.arange(0, start[-1] + lasts[-1], 1 / rate)
    stamps = random.uniform(0, 1 / frames) + np.arange(0, time[-1] - 0.05, 1 / frames)
    stamps = np.round(stamps + random.normal(0, 2e-4, len(stamps)), 6)
    q, x = random.uniform(0.4, 1.6), np.zeros(len(stamps))
    angle = np.zeros((len(time), 2))
    for k in range(knocks):
        x += ring(stamps - start[k], size[k], frequency[k], ratio[k])
        push = ring(time - start[k], size[k] / 40, frequency[k], 4 * ratio[k])
        angle += np.stack([push, push], axis=1) / 0.073
    # At rest on the line between the carriages.
    x_e, y_e = q + 0.005 * 0.55 / 1.112 + x, 0.55
    position = np.stack([x_e, x / 0.6, q + 0 * x, q + 0.005 + 0 * x, y_e + 0 * x], axis=1)
    sigma = np.array([1.9e-4, 2e-3, 1.9e-4, 1.9e-4, 1.9e-4])
    position += sigma * random.normal(size=position.shape)
    drive = DriveStream(
        time=time, voltage=np.zeros((len(time), 2)), angle=np.rint(angle / COUNT) * COUNT
    )
    camera = CameraStream(time=stamps, position=np.round(position, 6))
    whole = Run(
        name="0001-all", kind="free", pretension=350.0, pretension_label="350 N",
        drive=drive, camera=camera,
    )  # fmt: skip
    ends = np.append(start[1:] - 0.3, time[-1])
    single = [part(whole, k, start[k] - 0.3, ends[k], start[k]) for k in range(knocks)]
    return Recording(
        whole, Campaign(name="one by one", runs=tuple(single), counts_per_rev=COUNTS), frequency
    )


def ring(time, size, frequency, ratio):
    """A decaying sine from 15 ms after the push's begin on."""
    after = np.maximum(time - 0.015, 0.0)
    omega = 2 * np.pi * frequency
    return size * np.exp(-ratio * omega * after) * np.sin(omega * after)


def part(whole, number, begin, end, knock):
    rows = (whole.drive.time >= begin) & (whole.drive.time < end)
    frames = (whole.camera.time >= begin) & (whole.camera.time < end)
    return dataclasses.replace(
        whole,
        name=f"{number + 1:04d}-knock",
        kind="pseudo_impulse",
        drive=DriveStream(
            time=whole.drive.time[rows],
            voltage=whole.drive.voltage[rows],
            angle=whole.drive.angle[rows],
        ),
        camera=CameraStream(
            time=whole.camera.time[frames], position=whole.camera.position[frames]
        ),
        knock=Knock(start=round(knock, 4), duration=0.03),
    )
