"""Criteria in closed form; predictions against a fit; the search against its starts."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from experiments import recovery
from experiments.known_rig import left
from experiments.next_run import known_rig
from identification.campaign import CameraStream, DriveStream, Knock, Run
from identification.campaign.types import encoder_resolution
from identification.estimate import estimate
from identification.excitation import KNOCK_TIME, REST, STEP, catalogue
from identification.next_experiment import (
    KNOTS,
    _hats,
    _judged,
    a_optimal,
    d_optimal,
    propose,
    sharpest,
)

INFORMATION = np.array([[400.0, 30.0], [30.0, 9.0]])


def test_the_sharpest_criterion_is_the_logarithm_of_a_standard_error():
    sigma = np.sqrt(np.diag(np.linalg.inv(INFORMATION)))
    for index in range(2):
        found = float(sharpest(index)(jnp.asarray(INFORMATION)))
        np.testing.assert_allclose(found, np.log(sigma[index]), rtol=1e-12)


def test_the_d_criterion_is_the_mean_logarithm_of_the_ellipsoids_axes():
    axes = 1 / np.sqrt(np.linalg.eigvalsh(INFORMATION))
    found = float(d_optimal(jnp.asarray(INFORMATION)))
    np.testing.assert_allclose(found, np.mean(np.log(axes)), rtol=1e-12)


def test_the_a_criterion_counts_every_quantity_by_what_is_known_of_it():
    now = np.sqrt(np.diag(np.linalg.inv(INFORMATION)))
    assert abs(float(a_optimal(now)(jnp.asarray(INFORMATION)))) < 1e-12
    # Four times the information halves every standard error.
    halved = float(a_optimal(now)(jnp.asarray(4 * INFORMATION)))
    np.testing.assert_allclose(halved, np.log(0.5), rtol=1e-12)


def test_what_the_search_adds_is_interpolated_and_nothing_before_and_after_the_motion():
    spread = _hats(100, 120)
    assert spread.shape == (120, KNOTS)
    sums = spread.sum(axis=1)
    np.testing.assert_allclose(sums[20:70], 1.0)
    assert not sums[:20].any()
    assert not sums[70:].any()


POSES = ((0.4, 0.55), (1.1, 0.45))


@pytest.fixture(scope="module")
def drawn():
    """A drawn robot, its logs, and the rig as their fit knows it."""
    truth = recovery.draw(3)
    logs = recovery.campaign(truth, 3)
    found = estimate(logs)
    rows = [p for p in found.parameters if p.status != "fixed"]
    rig = known_rig(
        found.of_setting(recovery.SETTING),
        rows,
        found.correlation,
        setting=recovery.SETTING,
        channels=left(found),
        top_speed=1.5,
    )
    return truth, logs, rig._replace(log_rate=1 / recovery.PERIOD)


@pytest.fixture(scope="module")
def proposed(drawn):
    _, _, rig = drawn
    excitations = catalogue(limit=10.0, duration=1.6, poses=POSES)
    aim = sharpest(rig.names.index("friction_coefficient"))
    return propose(rig, excitations, aim, iterations=25)


@pytest.mark.slow
def test_what_is_designed_beats_every_start_of_the_catalogue(proposed):
    starts = [one for one in proposed if not one.designed]
    assert proposed[0].designed
    assert proposed[0].rate > 1.02 * max(one.rate for one in starts)


@pytest.mark.slow
def test_what_is_designed_keeps_within_voltage_frame_and_speed(drawn, proposed):
    _, _, rig = drawn
    again = _judged(rig, [one.excitation for one in proposed], d_optimal, 0.0, lambda *_: None)
    # Only what keeps within frame and speed is judged.
    assert len(again) == len(proposed)
    assert all(np.max(np.abs(one.excitation.voltage)) <= 10.0 for one in proposed)


def logged(truth, excitation, seed):
    """A run of the drawn robot under an excitation, as `recovery.campaign` logs them."""
    random = np.random.default_rng(seed)
    each = round(STEP / recovery.PERIOD)
    volts = np.repeat(excitation.voltage, each, axis=0)
    time = recovery.PERIOD * np.arange(volts.shape[0] + 1)
    pushed = (time[:-1] > REST - 1e-4) & (time[:-1] < REST + KNOCK_TIME - 1e-4)
    stamps = random.uniform(2e-3, 30e-3) + np.arange(int(time[-1] * 30) - 1) / 30
    x, y = excitation.start
    angle, frame = recovery._simulated(
        truth.robot,
        jnp.array([x, x, y]) + random.normal(0, 5e-4, 3) * np.array([0, 0, 1]),
        jnp.asarray(volts),
        jnp.asarray(np.where(pushed, excitation.knock, 0.0)),
        jnp.asarray(stamps),
    )
    count = encoder_resolution(recovery.COUNTS_PER_REV)
    sigma = np.array([1.9e-4, 2e-3, 1.9e-4, 1.9e-4, 1.9e-4])
    return Run(
        name="0005-designed",
        kind="pseudo_impulse" if excitation.knock else "torque_step",
        pretension=350.0,
        pretension_label=recovery.SETTING,
        drive=DriveStream(
            time=time,
            voltage=np.concatenate([volts, np.zeros((1, 2))]),
            angle=np.round(np.asarray(angle) / count) * count,
        ),
        camera=CameraStream(
            time=stamps,
            position=np.asarray(frame) + sigma * random.normal(size=(len(stamps), 5)),
        ),
        knock=Knock(start=REST, duration=KNOCK_TIME) if excitation.knock else None,
    )


@pytest.mark.slow
def test_the_predicted_standard_error_is_that_of_a_fit_with_the_designed_run(drawn, proposed):
    truth, logs, rig = drawn
    best = proposed[0]
    more = dataclasses.replace(logs, runs=(*logs.runs, logged(truth, best.excitation, 8)))
    found = {p.name: p for p in estimate(more).parameters}["friction_coefficient"]
    predicted = best.sigma[rig.names.index("friction_coefficient")]
    # Readings about the turning points are counted one by one there, on average here.
    np.testing.assert_allclose(found.sigma / found.value, predicted, rtol=0.25)
