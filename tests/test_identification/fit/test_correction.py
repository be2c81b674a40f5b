"""Deferred correction on a run that the coarser grid errs on."""

import dataclasses

import jax
import numpy as np
import pytest
from short_runs import bare_run

from identification.campaign import Campaign
from identification.fit.correction import corrected
from identification.fit.problem import Problem
from identification.fit.unknowns.options import FitOptions


def moving_problem():
    """A driven run at 500 Hz; what was measured of it is made up."""
    time = np.arange(250) * 2e-3
    voltage = np.where(time[:, None] > 0.1, [[9.0, 8.0]], 0.0)
    run = bare_run("torque_step")
    drive = dataclasses.replace(
        run.drive, time=time, voltage=voltage, angle=0.1 * np.sin(9 * time)[:, None] * [1, 1]
    )
    camera = dataclasses.replace(
        run.camera, time=time[::16], position=run.camera.position[: time[::16].size]
    )
    run = dataclasses.replace(run, drive=drive, camera=camera)
    return Problem.of(Campaign(name="driven", runs=(run,)), FitOptions())


@pytest.mark.slow
def test_the_coarser_grid_leaves_what_the_exact_one_leaves():
    with jax.enable_x64(True):
        problem = moving_problem()
        point = problem.at_rest()
        _, _, frame = problem.predictions(point)
        logs = problem.logs
        exact = logs.records.frame_weight * (logs.records.frame - frame)
        before = problem.cabled_sums([point], [0]).residuals.frame
        after = corrected(problem, point).cabled_sums([point], [0]).residuals.frame
    assert np.max(np.abs(before - exact)) > 1e-4
    # Numbers of up to some thousand standard deviations, to their rounding.
    np.testing.assert_allclose(after, exact, atol=1e-9 * np.max(np.abs(exact)))
