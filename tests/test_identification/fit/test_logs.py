import dataclasses

import numpy as np
from short_runs import bare_run

from identification.campaign import Campaign
from identification.campaign.types import Initial
from identification.fit.logs import COARSE_STEP, Logs
from scdpr_jax.robot.prototype import consistent

RUNS = (bare_run("motor_step"), bare_run("torque_step"), bare_run("pseudo_impulse"))


def logs(runs=RUNS):
    campaign = Campaign(name="still", runs=runs)
    return Logs.of(campaign, consistent(), clock_drifts=False)


def test_runs_keep_the_campaigns_numbers():
    assert logs().motors == (0,)
    assert logs().cabled == (1, 2)


def test_a_drive_that_stands_is_measured_once_on_either_grid():
    run = dataclasses.replace(bare_run("torque_step"), camera=None)
    fine = np.arange(1000) * 1e-3
    still = np.zeros((1000, 2))
    drive = dataclasses.replace(run.drive, time=fine, voltage=still, angle=still)
    place = {"x_e": 1.0, "y_e": 0.5}
    run = dataclasses.replace(run, drive=drive, initial=Initial(**place))
    of_run = logs((run,))
    assert of_run.factor == round(COARSE_STEP / 1e-3)
    # Two encoders, each with one reading that stands throughout.
    np.testing.assert_allclose(of_run.measurements(0), 2.0, rtol=1e-9)
    np.testing.assert_allclose(float(np.sum(of_run.records.angle_share)), 2.0, rtol=1e-9)


def test_the_drives_alone_are_the_same_runs_under_the_same_numbers():
    alone = logs().of_drives()
    assert (alone.cabled, alone.motors) == ((), (0,))
    assert alone.records is None
    assert alone.measurements(0) == logs().measurements(0)
