"""A push is known to a small part of a frame, and by as much as it says."""

import numpy as np
import pytest

from identification.campaign import CameraStream, Campaign, DriveStream, Run
from identification.doctor.case import record_of, rig_of
from identification.doctor.samples.motion import onset
from identification.doctor.samples.push import push

PLACE = np.array([1.12, 0.0, 1.12, 1.12, 0.556])
NOISE = 1.9e-4


PARTS = 50
STEADY = np.ones(PARTS)
HALF_SINE = np.pi / 2 * np.sin(np.pi * (np.arange(PARTS) + 0.5) / PARTS)


def swung(since, length, omega, damping):
    """Way of an oscillator after a push of 1 m/s^2 that began some time ago."""

    def lasting(t):
        t = np.maximum(t, 0.0)
        wave = np.cos(omega * t) + damping * np.sin(omega * t)
        return (1 - np.exp(-damping * omega * t) * wave) / omega**2

    return lasting(since) - lasting(since - length)


def pushed(random, rate, *, begin, length, shape=STEADY, frequency=3.2, force=20.0):
    """A run in which the end-effector is pushed between carriages that hold."""
    time = np.arange(0, 2.0, 1e-3)
    stamps = random.uniform(0.1, 0.9) / rate + np.arange(int(2 * rate) - 1) / rate
    place = np.tile(PLACE, (stamps.size, 1))
    for number, part in enumerate(shape):
        since = stamps - begin - number * length / PARTS
        place[:, 0] += part * force * swung(since, length / PARTS, 2 * np.pi * frequency, 0.013)
    place += random.normal(size=place.shape) * np.array([NOISE, 2e-3, NOISE, NOISE, NOISE])
    still = np.zeros((time.size, 2))
    run = Run(
        name="0001-knock",
        kind="pseudo_impulse",
        pretension=350.0,
        pretension_label="350 N",
        drive=DriveStream(time=time, voltage=still, angle=still),
        camera=CameraStream(time=stamps, position=place),
    )
    return record_of(run), rig_of(Campaign(name="pushed", runs=(run,)))


def told(*drawn):
    record, rig = drawn
    return push(record, rig, onset(record, rig))


@pytest.mark.parametrize("shape", [STEADY, HALF_SINE], ids=["steady", "half a sine"])
@pytest.mark.parametrize("rate", [25, 30, 60, 100, 200])
@pytest.mark.parametrize("length", [0.012, 0.03, 0.06])
def test_a_push_begins_within_a_frame(rate, length, shape):
    random = np.random.default_rng(rate)
    found = told(*pushed(random, rate, begin=0.3137, length=length, shape=shape))
    assert abs(found.begin - 0.3137) < 1 / rate
    middle = found.begin + found.length / 2
    assert abs(middle - 0.3137 - length / 2) < 0.003 + 0.2 / rate


def test_a_push_is_known_by_as_much_as_it_says():
    random = np.random.default_rng(3)
    errors = []
    for number in range(30):
        rate, shape = (30.0, 100.0, 500.0)[number % 3], (STEADY, HALF_SINE)[number % 2]
        begin, length = random.uniform(0.2, 0.6), random.uniform(0.015, 0.06)
        found = told(*pushed(random, rate, begin=begin, length=length, shape=shape))
        errors.append(abs(found.begin - begin) / found.begin_sigma)
    assert np.sum(np.array(errors) < 2) >= 27
    assert np.median(errors) > 0.1


def test_fast_frames_tell_the_length_and_slow_ones_the_usual_one():
    random = np.random.default_rng(4)
    fast = told(*pushed(random, 500.0, begin=0.3, length=0.06))
    slow = told(*pushed(random, 25.0, begin=0.3, length=0.012))
    assert abs(fast.length - 0.06) < 0.004
    assert fast.length_sigma < 0.1 * fast.length
    assert slow.length_sigma > 0.2 * slow.length


def test_a_long_push_is_seen_in_a_longer_window():
    found = told(*pushed(np.random.default_rng(5), 100.0, begin=0.4, length=0.12))
    assert found.length > 0.1  # the first window ends before that
    assert abs(found.begin - 0.4) < found.begin_sigma < 0.02


def test_two_frames_tell_no_push():
    record, rig = pushed(np.random.default_rng(6), 30.0, begin=0.3, length=0.03)
    record.position[record.frame_time > 0.37] = np.nan
    assert push(record, rig, onset(record, rig)) is None
