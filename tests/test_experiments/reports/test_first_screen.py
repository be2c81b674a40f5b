import dataclasses
import math

import numpy as np
from report_samples import campaign, estimate, parameter, tuning

from experiments.reports.calibration.first_screen import first_screen
from experiments.studies.findings.findings import findings
from experiments.studies.trust import trust
from tuning.result.prediction import LegsOutcome, PredictedLegs


def sure():
    """An estimate without a doubt."""
    parameters = (
        parameter("friction_coefficient", 0.013, 1e-5, unit="1"),
        parameter("drive_inertia", 0.0131, 1e-6, unit="kg m^2"),
        parameter("effective_pretension", 85.0, 0.05, unit="N", setting="350 N"),
    )
    return estimate(parameters=parameters)


def legs(*, planned):
    before = LegsOutcome(np.array([1e-3, 2e-3, 9e-3]), np.array([4e-3, 5e-3, 6e-3]))
    after = LegsOutcome(np.array([1e-4, 2e-4, 9e-4]), np.array([1e-3, 2e-3, 3e-3]))
    first = LegsOutcome(np.array([1e-5, 3e-5]), np.array([1e-4, 2e-4]))
    return PredictedLegs(before, after, 5, first if planned else None)


def test_the_quantities_of_the_paper_come_first_with_their_intervals():
    rows = first_screen(findings(sure(), campaign=campaign())).robot
    assert [row.symbol[0] for row in rows] == ["μ", "T", "J"]
    # Twice 0.05 N of 85 N; a fifth digit isn't worth printing at a glance.
    assert (rows[1].value, rows[1].interval) == ("85.000 N", "± 0.12 %")
    assert rows[1].name == "pretension at 350 N"


def test_other_quantities_are_counted_and_left_to_the_table():
    more = parameter("drive_friction", 0.05, 1e-4, unit="N m")
    good = findings(sure(), campaign=campaign())
    fitted = dataclasses.replace(
        good.estimate.fitted, parameters=(more, *good.estimate.parameters)
    )
    told = dataclasses.replace(good, estimate=dataclasses.replace(good.estimate, fitted=fitted))
    first = first_screen(told)
    assert [row.symbol[0] for row in first.robot] == ["μ", "T", "J"]
    assert first.more == 1


def test_a_value_that_nothing_tells_has_no_interval():
    good = findings(sure(), campaign=campaign())
    unknown = parameter("drive_inertia", 0.01, math.inf, unit="kg m^2", status="unidentifiable")
    mu, _, *others = good.estimate.parameters
    fitted = dataclasses.replace(good.estimate.fitted, parameters=(mu, unknown, *others))
    told = dataclasses.replace(good, estimate=dataclasses.replace(good.estimate, fitted=fitted))
    row = next(row for row in first_screen(told).robot if row.symbol[0] == "J")
    assert (row.value, row.interval, row.flag) == ("not told", "", "unidentifiable")


def test_every_law_that_is_exported_stands_beside_the_one_before():
    tuned = dataclasses.replace(tuning(), legs=legs(planned=True))
    first = first_screen(findings(sure(), campaign=campaign(), tuning=tuned))
    assert [law.name for law in first.laws] == [
        "before, Eq. (25)",
        "gains and shapers",
        "planned",
    ]
    assert [law.vibration for law in first.laws] == [
        "2.0 (9.0)",
        "0.20 (0.90)",
        "0.020 (0.030)",
    ]
    assert "over 3 random legs" in first.legs
    assert "planned ones over the first 2" in first.legs


def test_without_a_plan_none_is_told():
    tuned = dataclasses.replace(tuning(), legs=legs(planned=False))
    first = first_screen(findings(sure(), campaign=campaign(), tuning=tuned))
    assert len(first.laws) == 2
    assert "planned" not in first.legs


def test_a_fit_without_a_doubt_is_trusted_because_it_predicts():
    told = trust(findings(sure(), campaign=campaign()))
    assert (told.level, told.word) == ("good", "Yes")
    assert "0002-manoeuvre, which was not fitted, is predicted to" in told.reason


def test_a_weak_quantity_asks_for_care_and_is_named():
    told = trust(findings(estimate(), campaign=campaign()))
    assert (told.level, told.word) == ("care", "With care")
    assert "Drive inertia: only weakly identified." in (told.reason, *told.others)


def test_more_than_noise_is_the_first_reason_for_care():
    told = trust(findings(estimate(off=5e-3), campaign=campaign()))
    assert told.level == "care"
    assert "1 of 16 channels leave more than noise, most of all xₑ of 0001" in told.reason


def test_a_fit_that_has_failed_is_not_trusted():
    failed = dataclasses.replace(
        findings(estimate(), campaign=campaign()), verdict=("Why.", "b")
    )
    assert trust(failed) == trust(failed)
    assert (trust(failed).level, trust(failed).reason) == ("bad", "Why.")
