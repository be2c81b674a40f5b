"""Recovery of a virtual rig's truth from a few of its runs."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from experiments.virtual_rig import rig
from experiments.virtual_rig.recovery import DRAWN
from identification.data.circumstances import START
from identification.data.record import Reading, stacked
from identification.data.start import Clock
from identification.fit.run_sums import residuals_and_jacobian, run_residuals
from identification.fit.unknowns.measured import MeasuredQuantity
from identification.fit.unknowns.options import FitOptions
from identification.fit.unknowns.unknowns import encode
from identification.result.estimation import estimate
from scdpr_jax.robot.prototype import consistent

RUNS = ("0001-torque-step", "0003-torque-step", "0008-pseudo-impulse", "0013-motor-step")
HELD_OUT = "0010-pseudo-impulse"
OFFSET = 0.0213
ARM = 0.02
"""Height above the centre of mass at which the end-effector is knocked [m]."""


@pytest.fixture(scope="module")
def truth():
    drawn = rig.draw_truth(3)
    robot = eqx.tree_at(lambda r: r.end_effector.knock_arm, drawn.robot, jnp.asarray(ARM))
    return drawn._replace(robot=robot)


@pytest.fixture(scope="module")
def campaign(truth):
    """Four runs and one to predict; one camera's clock is off and nobody says by how much."""
    few = rig.campaign(truth, 3).with_runs([*RUNS, HELD_OUT])
    first, *others = few.runs
    shifted = dataclasses.replace(first.camera, time=first.camera.time + OFFSET)
    first = dataclasses.replace(first, camera=shifted, clock_offset=None)
    return dataclasses.replace(few, runs=(first, *others))


@pytest.fixture(scope="module")
def found(campaign):
    return estimate(campaign, FitOptions(hold_out=[HELD_OUT]))


@pytest.mark.parametrize("name", DRAWN)
def test_every_truth_is_inside_its_interval_from_a_start_far_away(found, truth, name):
    (parameter,) = (p for p in found.parameters if p.name == name)
    low, high = parameter.interval(0.997)
    assert low <= truth.values[name] <= high
    assert parameter.status == "identified"


@pytest.mark.parametrize("name", DRAWN)
def test_the_estimate_is_as_close_as_a_user_needs(found, truth, name):
    (parameter,) = (p for p in found.parameters if p.name == name)
    needed = 0.005 if name.startswith("drive") else 0.02
    assert abs(parameter.value / truth.values[name] - 1) < needed


def test_an_unknown_clock_is_found(found):
    assert abs(float(found.circumstances[RUNS[0]].clock_offset) - OFFSET) < 2e-4


def test_where_the_end_effector_was_knocked_is_found(found):
    # 1.4 mm would be a standard deviation's part in a hundred of the prior.
    assert abs(float(found.circumstances[RUNS[2]].knock_arm) - ARM) < 2e-3


def test_residuals_of_a_rig_that_is_the_model_are_noise(found):
    assert all(channel.is_noise for run in found.comparisons for channel in run.channels)


def test_a_run_that_was_held_out_is_predicted_within_the_noise(found):
    (held,) = (run for run in found.comparisons if run.held_out)
    assert held.name == HELD_OUT
    seen = np.abs(held.measured[:, 0] - held.simulated[:, 0])
    # Sixty Gaussian frames stay within 4.5 standard deviations of 0.19 mm.
    assert np.nanmax(seen) < 4.5 * 1.9e-4


def test_the_friction_force_is_known_better_than_its_coefficient(found):
    """What holds a carriage is the product of coefficient and tension, and a run shows that."""
    estimated = [p for p in found.parameters if p.status != "fixed"]
    names = [p.name for p in estimated]
    pair = [names.index(name) for name in ("friction_coefficient", "effective_pretension")]
    relative = np.array([estimated[k].sigma / estimated[k].value for k in pair])
    spread = found.correlation[np.ix_(pair, pair)] * np.outer(relative, relative)
    assert np.sqrt(np.sum(spread)) < relative[0]


def test_a_drifting_clock_is_found_and_would_be_taken_for_a_robot(campaign, truth):
    """At 1 m/s a thousandth of a few seconds is millimetres; the camera sees a tenth."""
    drift = 1e-3

    def drifting(run):
        if run.camera is None:
            return run
        begun = run.drive.time[0]
        time = begun + (run.camera.time - begun) * (1 + drift)
        return dataclasses.replace(run, camera=dataclasses.replace(run.camera, time=time))

    logs = dataclasses.replace(campaign, runs=tuple(map(drifting, campaign.runs)))
    found = estimate(logs, FitOptions(hold_out=[HELD_OUT], clock_drifts=True))
    drifts = [float(found.circumstances[name].clock_drift) for name in RUNS[:2]]
    np.testing.assert_allclose(drifts, drift, atol=0.15 * drift)
    assert all(channel.is_noise for run in found.comparisons for channel in run.channels)
    for name in DRAWN:
        (parameter,) = (p for p in found.parameters if p.name == name)
        low, high = parameter.interval(0.997)
        assert low <= truth.values[name] <= high
    ignored = estimate(logs, FitOptions(hold_out=[HELD_OUT]))
    assert not all(channel.is_noise for run in ignored.comparisons for channel in run.channels)


def test_what_was_measured_otherwise_weighs_by_its_error(campaign, found):
    """Two sources of one quantity combine as independent numbers do: by their precision."""
    name = "friction_coefficient"
    (logged,) = (p for p in found.parameters if p.name == name)
    # A standard error off, and its own one and a half times as large.
    other = MeasuredQuantity(
        quantity=name, value=logged.value + logged.sigma, sigma=1.5 * logged.sigma
    )
    both = estimate(campaign, FitOptions(hold_out=[HELD_OUT], measured=[other]))
    (joint,) = (p for p in both.parameters if p.name == name)
    weights = np.array([1.0, 1 / 1.5**2])
    assert joint.sigma == pytest.approx(logged.sigma / np.sqrt(weights.sum()), rel=0.01)
    moved = (joint.value - logged.value) / logged.sigma
    # A fit ends where a step promises a hundredth of misfit, a tenth of a standard error.
    assert moved == pytest.approx(weights[1] / weights.sum(), abs=0.1)
    assert both.options.measured == (other,)


def test_float32_is_refused(campaign):
    with jax.enable_x64(False), pytest.raises(ValueError, match="float64"):
        estimate(campaign)


@pytest.mark.parametrize(
    "beginning",
    [(), pytest.param((1e-3, 0.02, 0.3, -0.5, 0.2, 3.0, 2.5), marks=pytest.mark.slow)],
    ids=["at rest", "in motion"],
)
def test_jacobians_agree_with_differences(campaign, truth, beginning):
    """Forward mode through sticks and slips against central differences."""
    run = campaign.run(RUNS[2])
    reading = Reading(height=1.112, radius=0.073, in_motion=bool(beginning))
    record = jax.tree.map(
        lambda leaf: jnp.asarray(leaf[0]),
        stacked([run], [Clock(0.0, 0.0)], campaign.sensors, reading),
    )
    free = [encode(name, truth.values[name]) for name in DRAWN]
    point = jnp.array([*free, *record.prior.mean[START], -40.0, 0.01, 0.0, 0.0, *beginning])
    robot = consistent()

    def frames(x):
        return run_residuals(robot, DRAWN, x, record).frame.ravel()

    whole = jax.jit(lambda x: residuals_and_jacobian(robot, DRAWN, x, record))
    slope = whole(point)[1].frame.reshape(-1, point.size)
    evaluate = jax.jit(frames)
    for column in range(point.size):
        # Rounding of 1e-16 m over 2e-4 m and a step of 1e-6 leave 1e-6; curvature as much.
        step = 1e-6 * max(1.0, abs(float(point[column])))
        shift = jnp.zeros(point.size).at[column].set(step)
        difference = (evaluate(point + shift) - evaluate(point - shift)) / (2 * step)
        scale = jnp.max(jnp.abs(difference)) + 1e-3
        np.testing.assert_allclose(slope[:, column] / scale, difference / scale, atol=2e-4)
