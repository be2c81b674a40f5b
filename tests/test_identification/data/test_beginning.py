"""How a run in motion begins, by its first samples and in a fit."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from experiments.virtual_rig import recovery
from identification.campaign import Campaign, Run
from identification.campaign.types import default_sensors
from identification.data.beginning import drive_speeds, start_in_motion
from identification.data.circumstances import BEGINNING, NAMES, TURNING_DRIVES, Circumstances
from identification.doctor.samples.begin import at_begin
from identification.fit.residuals import begun
from identification.fit.unknowns.options import FitOptions
from identification.result.estimation import estimate
from scdpr_jax.robot.state import rest

HEIGHT, RADIUS = 1.112, 0.073
SENSORS = default_sensors(26624.0)


@pytest.fixture(scope="module")
def logged() -> tuple[Run, ...]:
    """Two steps, a knock at 0.3 s and a step of the bare drives."""
    return recovery.campaign(recovery.draw(1), 1).runs


def cut(run: Run, begin: float) -> Run:
    """A run whose logger was started late."""
    late = run.drive.time >= begin
    drive, camera = run.drive, run.camera
    drive = dataclasses.replace(
        drive, time=drive.time[late], voltage=drive.voltage[late], angle=drive.angle[late]
    )
    if camera is not None:
        seen = camera.time >= begin
        camera = dataclasses.replace(
            camera, time=camera.time[seen], position=camera.position[seen]
        )
    return dataclasses.replace(run, drive=drive, camera=camera, in_motion=True)


def cut_campaign(seed: int) -> tuple[recovery.Truth, Campaign, Campaign]:
    """A drawn robot, its campaign, and the same with all but the knock cut in motion."""
    truth = recovery.draw(seed)
    whole = recovery.campaign(truth, seed)
    random = np.random.default_rng([seed, 9])
    runs = [
        run if run.kind == "pseudo_impulse" else cut(run, float(random.uniform(0.15, 0.4)))
        for run in whole.runs
    ]
    return truth, whole, dataclasses.replace(whole, runs=tuple(runs))


def test_value_and_slope_at_the_first_row_are_known_by_as_much_as_is_said():
    random = np.random.default_rng(0)
    time, errors = np.arange(20) * 2e-3, []
    for _ in range(200):
        a, b, c = random.uniform(-1, 1, 3) * [1.0, 5.0, 30.0]
        seen = a + b * time + c * time**2 + 1e-3 * random.normal(size=20)
        begin = at_begin(time, seen, 0.04, 1e-3)
        errors.append([(begin.value - a) / begin.error, (begin.slope - b) / begin.slope_error])
    inside = np.mean(np.abs(errors) < 2, axis=0)
    assert np.all(inside > 0.9)
    assert np.all(np.std(errors, axis=0) > 0.4)


def test_too_few_samples_tell_no_slope():
    begin = at_begin(np.arange(4) * 0.01, np.array([0.3, np.nan, 0.4, 0.5]), 0.04, 1e-3)
    assert begin.value == 0.3
    assert begin.error == begin.slope_error == np.inf


def test_a_run_at_rest_begins_with_zeros(logged):
    still = logged[2]
    known = start_in_motion(still, 0.0, SENSORS, height=HEIGHT, radius=RADIUS)
    assert np.all(np.abs(known.beginning.value) < 2 * known.beginning.sigma)
    np.testing.assert_allclose(known.position, still.camera.position[0, 2:], atol=2e-3)


def test_the_drives_begin_at_the_speed_of_their_encoders(logged):
    run = logged[3]
    known = drive_speeds(cut(run, 0.4), SENSORS)
    row = int(np.argmax(run.drive.time >= 0.4))
    around = run.drive.time[[row - 4, row + 4]], run.drive.angle[[row - 4, row + 4]]
    speed = (around[1][1] - around[1][0]) / (around[0][1] - around[0][0])
    np.testing.assert_array_less(np.abs(known.value - speed), 3 * known.sigma)
    assert np.all(known.sigma < 0.01 * np.abs(speed))


def test_a_state_in_motion_is_that_at_rest_and_what_is_added():
    truth = recovery.draw(2)
    numbers = np.concatenate([[0.6, 0.61, 0.5, 0, 0, 0, 0], [1e-3, 2e-2, 0.3, -1.0, 0.2, 4, 2]])
    state = begun(truth.robot, Circumstances.of(jnp.asarray(numbers)))
    still = rest(truth.robot, *jnp.asarray(numbers[:3]))
    np.testing.assert_allclose(
        state.position - still.position, [1e-3, 2e-2, 0, 0, 0], atol=1e-15
    )
    radius = float(truth.robot.drive.effective_radius)
    np.testing.assert_allclose(state.velocity, [0.3, -1.0, 3 * radius, 0.2, radius])


def test_circumstances_with_a_beginning_come_back_from_their_vector():
    numbers = np.arange(len(NAMES) + len(BEGINNING), dtype=float)
    circumstances = Circumstances.of(numbers)
    np.testing.assert_array_equal(circumstances.vector, numbers)
    assert float(circumstances.beginning.drive_2_speed) == numbers[-1]
    assert BEGINNING[-2:] == TURNING_DRIVES


def test_bare_drives_that_only_turn_on_tell_no_more_than_their_rank():
    # From the nameplate's inertia a fit of this robot ends at drives without any.
    truth, _, late = cut_campaign(126)
    options = FitOptions(free=("drive_inertia", "drive_damping", "drive_friction"))
    drives = estimate(late.with_runs(["0004-motor-step"]), options)
    assert drives.fits
    estimated = {parameter.name: parameter for parameter in drives.parameters}
    # At one steady speed friction is as good as damping: what is left is what is usual.
    assert estimated["drive_friction"].status == "unidentifiable"
    for name in ("drive_inertia", "drive_damping"):
        low, high = estimated[name].interval95
        assert low < truth.values[name] < high
        assert high - low > 0.1 * truth.values[name]


@pytest.mark.slow
def test_twenty_campaigns_cut_in_motion_are_fitted_as_whole_ones():
    inside, count = 0, 0
    for seed in range(300, 320):
        truth, whole, late = cut_campaign(seed)
        of_whole, of_late = estimate(whole, FitOptions()), estimate(late, FitOptions())
        assert of_late.fits
        for one, other in zip(of_whole.parameters, of_late.parameters, strict=True):
            if one.name in truth.values and other.status == "identified":
                assert abs(other.value - one.value) < 3 * np.hypot(one.sigma, other.sigma)
                low, high = other.interval95
                inside += low <= truth.values[one.name] <= high
                count += 1
    assert count >= 72
    assert inside >= 0.9 * count
