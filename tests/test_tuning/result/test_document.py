import dataclasses
import json

import jax
import numpy as np
import pytest
from hostile_documents import outcomes

from scdpr_jax.command.controller import published_pd
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import EVERY_QUANTITY, QUANTITIES, replace, value
from scdpr_jax.robot.stated.ranges import check_value
from tuning.loop.margins import sampled_margins
from tuning.loop.plant import published_plant
from tuning.loop.worst_margins import WorstMargin
from tuning.result.document import read_tuning, tuning_document, write_tuning
from tuning.result.prediction import LegsOutcome, Metrics, PredictedLegs, Prediction
from tuning.result.regional_shaper import Region, RegionalShaper, ResidualVibration
from tuning.result.tuning import CAUTION, FittedSetting, Tuning
from tuning.shapers.catalogue import ei

METRICS = Metrics(5e-3, 2e-3, 54e-3, 15e-3, 54e-3, 8.9, 0.0)
LEGS = PredictedLegs(
    LegsOutcome(np.array([4e-3, 2e-3, 6e-3, 2e-3]), np.full(4, 5e-3)),
    LegsOutcome(np.array([1e-3, 2.5e-3, 1.5e-3, 0.5e-3]), np.full(4, 4e-3)),
    robots=2,
)


@pytest.fixture(scope="module")
def tuning():
    margins = jax.jit(sampled_margins)(published_plant(), published_pd())
    region = Region((0.0, 2.224), (0.0, 1.112), (350.0, 350.0))
    left = ResidualVibration(0.05, 0.051)
    shaper = RegionalShaper(region, 0.6, ei(3.1, 0.0), 3.1, (3.09, 3.11), 0.0, True, left)
    predicted = Prediction("horizontal", METRICS, METRICS)
    robots = (FittedSetting(350.0, consistent()),)
    worst = (
        WorstMargin("phase_margin", 0.3, "lifting", 0.4, 350.0),
        WorstMargin("gain_margin", float("inf"), "lifting", 0.4, 350.0),
    )
    return Tuning(published_pd(), margins, (shaper,), (predicted,), robots, worst, ("A note.",))


def test_a_tuning_that_is_written_and_read_is_the_same(tuning, tmp_path):
    write_tuning(tmp_path / "tuning.json", tuning)
    again = read_tuning(tmp_path / "tuning.json")
    assert tuning_document(again) == tuning_document(tuning)


@pytest.fixture(scope="module")
def predicted(tuning):
    regional = dataclasses.replace(tuning.shapers[0], kind="own", share=0.25)
    return dataclasses.replace(tuning, shapers=(regional,), legs=LEGS)


def test_random_legs_that_are_written_and_read_are_the_same(predicted, tmp_path):
    write_tuning(tmp_path / "tuning.json", predicted)
    again = read_tuning(tmp_path / "tuning.json")
    assert tuning_document(again) == tuning_document(predicted)
    assert (again.shapers[0].kind, again.shapers[0].share) == ("own", 0.25)
    np.testing.assert_array_equal(again.legs.after.vibration, LEGS.after.vibration)


def test_random_legs_tell_what_is_left_of_the_robot_that_is_served_worst():
    assert LEGS.share == pytest.approx((0.25 * 1.25 * 0.25 * 0.25) ** 0.25)
    assert LEGS.worst_share == pytest.approx((1.25 * 0.25) ** 0.5)
    assert LEGS.worse == 0.25


def test_a_tuning_tells_its_random_legs(predicted):
    assert "  4 random legs: 37.4 % of the vibration left, predicted" in repr(predicted)


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda d: d["legs"]["before"]["residual_vibration"].pop(), r"lists of \[3, 4\] legs"),
        (lambda d: d["legs"].update(robots=5), "for 5 robots"),
        (lambda d: d["legs"]["after"].update(resting_error=[-1.0] * 4), "resting_error.0"),
        (lambda d: d["shapers"][0].update(share=-0.1), "share is wrong"),
    ],
)
def test_legs_that_cant_be_are_refused(predicted, tmp_path, change, where):
    with pytest.raises(ValueError, match=where):
        read_tuning(broken(predicted, tmp_path, change))


def test_a_tuning_says_in_a_few_lines_what_it_holds(tuning):
    lines = repr(tuning).splitlines()
    assert lines[0] == "Tuning: PD of 36.39 V/rad and 0.7162 V s/rad at 1000 Hz"
    assert lines[1] == "  shapers for 1 regions, 1 of them measured; settings: 350 N"
    assert lines[2] == "  horizontal: vibration 5 mm before, 5 mm after"
    assert lines[3:] == ["  A note."]


def test_the_robot_that_is_read_is_the_one_that_was_fitted(tuning, tmp_path):
    fitted = consistent()
    for share, one in enumerate(EVERY_QUANTITY, start=2):
        # A different number for each, and one that a robot may have.
        more = 1e-4 * share if one.unit == "m/N" else 0.01 * share
        fitted = replace(fitted, {one.name: float(value(fitted, one.name)) + more})
    robots = (FittedSetting(350.0, exact(fitted)),)
    write_tuning(tmp_path / "tuning.json", dataclasses.replace(tuning, robots=robots))
    again = read_tuning(tmp_path / "tuning.json").robot_at().robot
    assert jax.tree.all(jax.tree.map(lambda a, b: bool(a == b), again, exact(fitted)))


def test_a_robot_from_before_refinements_is_read(tuning, tmp_path):
    path = broken(
        tuning, tmp_path, lambda d: d["robots"][0]["parameters"].pop("loop_stiffness")
    )
    assert float(read_tuning(path).robot_at().robot.cable.stiffness) == 0.0


def test_a_shaper_from_before_heights_stands_for_the_middle_of_its_region(tuning, tmp_path):
    path = broken(tuning, tmp_path, lambda d: d["shapers"][0].pop("height"))
    assert read_tuning(path).shapers[0].height == 1.112 / 2


def test_a_setting_without_a_fitted_robot_is_refused(tuning):
    with pytest.raises(ValueError, match="at 200 N, got: 350 N"):
        tuning.robot_at(200.0)


def broken(tuning, tmp_path, change):
    document = json.loads(tuning_document(tuning))
    change(document)
    path = tmp_path / "tuning.json"
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda d: d.update(format=2), "format is wrong"),
        (lambda d: d["controller"]["proportional_gain"].update(unit="V/deg"), "unit is wrong"),
        (lambda d: d["shapers"][0].update(amplitudes=[0.5, 0.2, 0.1]), "sum to 0.8"),
        (lambda d: d["shapers"][0].update(times=[0.0, 0.2, 0.1]), "times decrease"),
        (lambda d: d["robots"][0]["parameters"].pop("drive_inertia"), "drive_inertia"),
        (
            lambda d: d["robots"][0]["parameters"]["loop_stiffness"].update(unit="N/mm"),
            "the unit of loop_stiffness: got 'N/mm'",
        ),
        (
            lambda d: d["robots"][0]["parameters"].update(
                springiness={"value": 1.0, "unit": "N/m"}
            ),
            "unknown quantity 'springiness'",
        ),
        (lambda d: d["predicted"]["horizontal"]["after"].popitem(), "expected the metrics"),
        (
            lambda d: d["robots"][0]["parameters"]["drive_inertia"].update(value=-0.01),
            "`drive_inertia` can't be a robot's, got -0.01",
        ),
        (
            lambda d: d["robots"][0]["parameters"]["drive_inertia"].update(value="0.01"),
            "drive_inertia.value is wrong, got '0.01'",
        ),
        (
            lambda d: d["controller"]["derivative_gain"].update(value=float("nan")),
            "derivative_gain.value is wrong",
        ),
        (
            lambda d: d["controller"]["proportional_gain"].update(value=-36.0),
            "proportional_gain.value is wrong, got -36.0",
        ),
        (lambda d: d["controller"]["period"].update(value=0.0), "period.value is wrong"),
        (lambda d: d["shapers"][0].update(times=[0.0, 1e9]), "times.1 is wrong"),
    ],
)
def test_a_broken_file_is_refused_with_its_place(tuning, tmp_path, change, where):
    with pytest.raises(ValueError, match=where):
        read_tuning(broken(tuning, tmp_path, change))


def check_usable(tuning):
    """Every number that a leg is planned with is one that can be."""
    for fitted in tuning.robots:
        for kind in QUANTITIES:
            check_value(kind.name, float(value(fitted.robot, kind.name)))
    controller = tuning.controller
    gains = (controller.proportional_gain, controller.derivative_gain, controller.filter_time)
    assert all(0 <= float(gain) < 1e7 for gain in gains)
    assert 0 < float(controller.period) <= 1
    for regional in tuning.shapers:
        times = np.asarray(regional.shaper.times)
        assert np.all(np.diff(times) >= 0)
        assert 0 <= times[0] <= times[-1] <= 3600


def refusals(tuning, path, *, seed, draws):
    """Reasons of hostile files; what isn't refused can be planned with."""
    document = json.loads(tuning_document(tuning))
    made = outcomes(read_tuning, document, path, seed=seed, draws=draws, judge=check_usable)
    reasons = [reason for reason in made if reason is not None]
    assert all(reason.startswith(f"{path}: ") and "got" in reason for reason in reasons)
    return reasons


def test_hostile_files_give_a_tuning_or_a_reason(tuning, tmp_path):
    assert len(refusals(tuning, tmp_path / "tuning.json", seed=1, draws=60)) > 30


@pytest.mark.slow
def test_a_thousand_hostile_files_give_a_tuning_or_a_reason(tuning, tmp_path):
    assert len(refusals(tuning, tmp_path / "tuning.json", seed=2, draws=1000)) > 500


def test_a_missing_file_says_which_command_writes_it(tmp_path):
    with pytest.raises(ValueError, match="scdpr tune"):
        read_tuning(tmp_path / "tuning.json")


def test_a_tuning_of_a_failed_fit_is_marked_and_stays_so(tuning, tmp_path):
    write_tuning(tmp_path / "tuning.json", dataclasses.replace(tuning, caution=CAUTION))
    assert json.loads((tmp_path / "tuning.json").read_text())["caution"] == CAUTION
    again = read_tuning(tmp_path / "tuning.json")
    assert again.caution == CAUTION
    assert CAUTION in repr(again)


def test_a_tuning_of_a_good_fit_bears_no_mark(tuning):
    assert "caution" not in json.loads(tuning_document(tuning))
