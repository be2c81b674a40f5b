import dataclasses

import knock_recording
import numpy as np
import pytest
import scipy.integrate

from identification.campaign import (
    AccelerometerStream,
    Campaign,
    Initial,
    Knock,
    read_campaign,
    write_campaign,
)
from identification.knocks.accelerometer import accelerometer_ring_down, joined
from identification.knocks.frequency_map import frequency_map

GRAVITY = 9.80665
SIGMA = 0.02 * GRAVITY


def pushed(random, *, rate=200.0):
    """A knocked end-effector's acceleration with a cheap chip's noise; frequency and knock."""
    frequency, ratio = random.uniform(2.0, 4.5), random.uniform(0.005, 0.03)
    omega, start = 2 * np.pi * frequency, random.uniform(0.4, 1.2)
    force = random.uniform(10, 40)

    def slope(t, state):
        push = force * np.sin(np.pi * (t - start) / 0.03) * (start < t < start + 0.03)
        return [state[1], push - 2 * ratio * omega * state[1] - omega**2 * state[0]]

    time = np.arange(0, random.uniform(4, 7), 1 / rate)
    found = scipy.integrate.solve_ivp(
        slope, (0, time[-1]), [0, 0], t_eval=time, max_step=2e-3, rtol=1e-8
    )
    a = np.array([slope(t, state)[1] for t, state in zip(time, found.y.T, strict=True)])
    a += random.uniform(-0.3, 0.3) + SIGMA * random.normal(size=len(a))
    return AccelerometerStream(time=time, along=a), frequency, Knock(start=start, duration=0.03)


@pytest.mark.slow
def test_a_hundred_knocks_give_their_frequency_inside_its_interval():
    errors, inside = [], []
    for seed in range(100):
        random = np.random.default_rng([5, seed])
        stream, frequency, knock = pushed(random, rate=random.choice([100.0, 200.0, 500.0]))
        stated = (knock.start, knock.start + knock.duration) if seed % 2 else None
        found = accelerometer_ring_down(stream, stated=stated)
        errors.append(abs(found.frequency / frequency - 1))
        inside.append(abs(found.frequency - frequency) < 1.96 * found.frequency_sigma)
    assert max(errors) < 3e-3
    assert np.mean(inside) >= 0.95


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 3))]
)
def test_a_knock_gives_its_frequency_whether_its_time_is_stated_or_not(seed):
    stream, frequency, knock = pushed(np.random.default_rng(seed))
    for stated in (None, (knock.start, knock.start + 0.03), (50.0, 50.03)):
        found = accelerometer_ring_down(stream, stated=stated)
        assert abs(found.frequency / frequency - 1) < 3e-3
        assert abs(found.frequency - frequency) < 4 * found.frequency_sigma


def test_without_a_knock_nothing_is_made_up():
    random = np.random.default_rng(4)
    time = np.arange(0, 4, 5e-3)
    stream = AccelerometerStream(time=time, along=SIGMA * random.normal(size=len(time)))
    with pytest.raises(ValueError, match="no knock stands out"):
        accelerometer_ring_down(stream, stated=None)


def knocked(number, random, *, filmed):
    """A run with a knock, with a camera or with [initial]."""
    stream, frequency, knock = pushed(random)
    run = knock_recording.recording(number, knocks=1).single.runs[0]
    return dataclasses.replace(
        run, name=f"{number:04d}", accelerometer=stream,
        camera=run.camera if filmed else None, knock=run.knock if filmed else knock,
        initial=None if filmed else Initial(x_e=0.5, y_e=0.4),
    ), frequency  # fmt: skip


def test_a_campaign_without_a_camera_has_its_frequencies(tmp_path):
    random = np.random.default_rng(7)
    (first, f_1), (second, f_2) = (knocked(k, random, filmed=False) for k in (1, 2))
    campaign = Campaign(name="phone", runs=(first, second), counts_per_rev=26624.0)
    write_campaign(campaign, tmp_path / "rig")
    read = read_campaign(tmp_path / "rig")
    np.testing.assert_array_equal(read.runs[0].accelerometer.along, first.accelerometer.along)
    found = frequency_map(read)
    np.testing.assert_allclose(found.frequency, [f_1, f_2], rtol=3e-3)
    np.testing.assert_array_equal(found.y, [0.4, 0.4])


def test_both_sensors_together_know_more_than_either():
    run, _ = knocked(3, np.random.default_rng(8), filmed=True)
    alone = dataclasses.replace(run, accelerometer=None)
    (camera,) = frequency_map(Campaign(name="a", runs=(alone,))).ring_downs
    # The same vibration as the camera's, that is: only the interval is another.
    other = dataclasses.replace(camera, frequency=camera.frequency + camera.frequency_sigma / 2)
    both = joined(camera, other)
    assert both.frequency_sigma == pytest.approx(camera.frequency_sigma / np.sqrt(2))
    assert both.frequency == pytest.approx(camera.frequency + camera.frequency_sigma / 4)


def test_sensors_that_disagree_are_less_certain_than_either():
    run, _ = knocked(3, np.random.default_rng(8), filmed=True)
    alone = dataclasses.replace(run, accelerometer=None)
    (camera,) = frequency_map(Campaign(name="a", runs=(alone,))).ring_downs
    other = dataclasses.replace(
        camera, frequency=camera.frequency + 20 * camera.frequency_sigma
    )
    assert joined(camera, other).frequency_sigma > 5 * camera.frequency_sigma
