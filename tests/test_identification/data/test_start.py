import dataclasses

import numpy as np
import pytest

from identification.campaign import CameraStream, DriveStream, Initial, Knock, Run, Sensors
from identification.data.start import Clock, clocks, rest_until, start_pose

RADIUS, HEIGHT = 0.073, 1.112
SENSORS = Sensors()


def moving_run(offset=0.0, *, seed=0, reach=0.3, clock=None, name="0001-free"):
    """A run whose carriage goes to and fro, seen by a camera with a clock of its own."""
    random = np.random.default_rng(seed)
    time = np.arange(2000) * 1e-3
    lower = reach * np.sin(np.maximum(time - 0.3, 0.0) * 4) ** 2
    angle = np.stack([lower, lower], axis=1) / RADIUS
    stamps = np.arange(0.011, 1.95, 1 / 30)
    position = np.zeros((stamps.size, 5))
    position[:, 2] = 0.5 + np.interp(stamps, time, lower)
    position[:, 3] = 0.49
    position[:, 4] = 0.6
    noise = random.normal(0, SENSORS.camera_position_sigma, position.shape)
    return Run(
        name=name,
        kind="free",
        pretension=350.0,
        pretension_label="350 N",
        drive=DriveStream(time=time, voltage=np.zeros((2000, 2)), angle=angle),
        camera=CameraStream(time=stamps + offset, position=position + noise),
        clock_offset=clock,
    )


def test_a_clock_is_found_from_the_motion_within_its_own_deviation():
    errors = []
    for seed in range(40):
        run = moving_run(0.0287, seed=seed)
        (clock,) = clocks([run], SENSORS, RADIUS)
        errors.append((clock.offset - 0.0287) / clock.sigma)
    # 40 standard normal draws: their root mean square is 1 within 0.5 but once in 10^4.
    assert 0.5 < np.sqrt(np.mean(np.square(errors))) < 1.5


def test_a_run_that_hardly_moves_learns_the_clock_from_the_others():
    runs = [moving_run(0.0287, seed=s, name=f"{s}") for s in range(3)]
    still = moving_run(0.0287, seed=9, reach=1e-5, name="still")
    clock = clocks([*runs, still], SENSORS, RADIUS)[-1]
    assert abs(clock.offset - 0.0287) < 4 * clock.sigma
    assert clock.sigma < 1e-3


def test_a_stated_clock_is_taken_as_it_is():
    (clock,) = clocks([moving_run(0.01, clock=0.01)], SENSORS, RADIUS)
    assert clock == Clock(offset=0.01, sigma=0.0)


def test_nobody_moving_leaves_the_clock_open():
    (clock,) = clocks([moving_run(0.01, reach=0.0)], SENSORS, RADIUS)
    assert clock.sigma >= 0.05


def test_the_start_is_the_mean_of_the_frames_before_anything_moves():
    run = moving_run(clock=0.0)
    start = start_pose(run, 0.0, SENSORS, HEIGHT)
    assert np.all(np.abs(start.position - [0.5, 0.49, 0.6]) < 4 * start.sigma)
    # Nine frames in 0.3 s, and the carriage's first millimetre takes a little longer.
    np.testing.assert_allclose(start.sigma, SENSORS.camera_position_sigma / 3, rtol=0.1)


def test_a_controllers_chatter_is_rest():
    run = moving_run(clock=0.0)
    chatter = np.zeros((2000, 2))
    chatter[30:] = 0.01
    restless = dataclasses.replace(run.drive, voltage=chatter)
    assert rest_until(dataclasses.replace(run, drive=restless)) == rest_until(run)


def test_a_knock_ends_the_rest():
    run = dataclasses.replace(
        moving_run(clock=0.0), kind="pseudo_impulse", knock=Knock(start=0.1, duration=0.03)
    )
    assert rest_until(run) == 0.1


def test_without_a_camera_the_noted_start_counts():
    run = dataclasses.replace(
        moving_run(clock=0.0), camera=None, initial=Initial(x_e=0.5, y_e=0.6)
    )
    start = start_pose(run, 0.0, SENSORS, HEIGHT)
    np.testing.assert_array_equal(start.position, [0.5, 0.5, 0.6])
    assert start.sigma[2] == 1e-3


def test_an_unknown_start_is_refused_with_its_remedy():
    run = dataclasses.replace(moving_run(clock=0.0), camera=None)
    with pytest.raises(ValueError, match=r"0001-free.*\[initial\].*run\.toml"):
        start_pose(run, 0.0, SENSORS, HEIGHT)
