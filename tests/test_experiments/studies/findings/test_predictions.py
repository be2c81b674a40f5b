import dataclasses
import math

import numpy as np
import pytest
from report_samples import comparison

from experiments.studies.findings.predictions import prediction
from scdpr_jax.robot.state import pose


def test_the_error_of_a_prediction_is_the_distance_in_the_plane():
    run = comparison("0001-manoeuvre", held_out=True)
    measured = run.simulated + np.array([3e-3, 0.0, 0.0, 0.0, 4e-3])
    one = prediction(dataclasses.replace(run, measured=measured), radius=0.073)
    assert one.error == pytest.approx(5e-3, rel=1e-9)  # differences of metres, in f64
    assert one.largest == pytest.approx(5e-3, rel=1e-9)
    moved = np.linalg.norm(np.ptp(pose(run.simulated), axis=0))
    assert one.share == pytest.approx(5e-3 / moved, rel=1e-9)


def test_frames_that_were_lost_are_left_out_of_a_prediction():
    run = comparison("0001-manoeuvre")
    lost = run.measured.copy()
    lost[::2] = np.nan
    one = prediction(dataclasses.replace(run, measured=lost), radius=0.073)
    assert math.isfinite(one.error)


def test_without_a_camera_the_encoders_say_how_good_a_prediction_is():
    run = comparison("0004-motor-step", camera=False)
    one = prediction(run, radius=0.073)
    noise = 0.073 * 1e-4 * math.sqrt(2)
    # Eight hundred draws: their root mean square is the noise within a tenth.
    assert one.error == pytest.approx(noise, rel=0.1)
