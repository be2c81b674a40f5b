import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
from report_samples import (
    CAMERA_SIGMA,
    DAMPING,
    FREQUENCY,
    campaign,
    estimate,
    frequencies,
    knock_ring_down,
)

from experiments.studies.findings.findings import findings
from experiments.studies.findings.knocks import knock_decay, model_curve
from scdpr_jax.linear.modes import BOTH_HELD, natural_frequencies
from scdpr_jax.robot.prototype import consistent


def test_the_model_curve_is_that_of_both_carriages_held():
    robot = consistent()
    curve = model_curve(robot)
    middle = len(curve.height) // 2
    expected = natural_frequencies(robot, jnp.asarray(curve.height[middle]), BOTH_HELD)
    # One batch against one at a time: an eigenvalue's few roundings.
    assert np.allclose(curve.frequency[middle], expected, rtol=1e-12)
    body = robot.end_effector
    assert curve.height[0] > float(body.lower_offset)
    assert curve.height[-1] < float(robot.frame.height - body.upper_offset)


def test_the_decay_passes_through_the_samples():
    run, fit = campaign().runs[2], knock_ring_down()
    assert fit.frequency == pytest.approx(FREQUENCY, abs=4 * fit.frequency_sigma)
    decay = knock_decay(run, fit)
    inside = decay.time >= fit.window[0]
    at = np.interp(decay.time[inside], decay.curve_time, decay.curve)
    rms = np.sqrt(np.mean((decay.displacement[inside] - at) ** 2))
    # Noise, and a tenth for the luck of some hundred draws.
    assert rms <= 1.1 * CAMERA_SIGMA
    assert fit.damping_ratio == pytest.approx(DAMPING, abs=4 * fit.damping_ratio_sigma)


def test_of_a_map_that_was_read_from_a_file_there_is_no_decay():
    read = dataclasses.replace(frequencies(), ring_downs=())
    assert findings(estimate(), campaign=campaign(), frequencies=read).decays == ()
