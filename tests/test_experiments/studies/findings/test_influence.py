import dataclasses

import numpy as np
from report_samples import estimate, estimated_parameters, influence

from experiments.reports.calibration.influence_tables import influence_tables
from experiments.studies.findings.influence import influence_sentences, influence_verdict


def with_influence(**changes):
    found = influence(estimated_parameters(), **changes)
    return dataclasses.replace(estimate(), influence=found)


def said(made):
    return influence_sentences(influence_verdict(made))


def test_a_run_that_moves_more_than_noise_is_named():
    told = " ".join(said(with_influence(moved=4.2)))
    assert (
        "Without 0001-manoeuvre the friction coefficient would be 4.2 standard errors" in told
    )
    assert "says something else than the others" in told


def test_a_run_that_moves_no_more_than_noise_is_not_blamed():
    told = " ".join(said(with_influence(moved=0.5)))
    assert "No run moves a quantity by more than noise explains" in told


def test_too_few_runs_for_a_bootstrap_are_said_to_be_too_few():
    told = " ".join(said(with_influence()))
    assert "Too few runs for a bootstrap of friction coefficient" in told
    assert influence_tables(with_influence())[1].rows[0][3] == "too few runs"


def test_an_interval_from_the_bootstrap_stands_beside_the_reported_one():
    (_, table) = influence_tables(with_influence(enough=True))
    assert table.rows[2] == (
        "T 350 N", "84.900", "85.100", "84.850", "85.150", "6.0"
    )  # fmt: skip


def test_a_quantity_that_one_run_alone_tells_is_named():
    made = with_influence()
    without = made.influence.without.copy()
    without[1, 1] = np.nan
    moved = np.where(np.isnan(without), np.nan, made.influence.moved)
    found = dataclasses.replace(made.influence, without=without, moved=moved)
    told = said(dataclasses.replace(made, influence=found))
    assert "Without 0004-motor-step nothing tells the drive inertia." in told
    (table, _) = influence_tables(dataclasses.replace(made, influence=found))
    assert table.rows[1][2] == "not told"


def test_residuals_beyond_noise_are_said_to_make_the_steps_too_short():
    made = dataclasses.replace(estimate(off=0.01), influence=with_influence().influence)
    assert any("--leave-out" in one for one in said(made))
    refitted = dataclasses.replace(made.influence, refitted=True)
    told = said(dataclasses.replace(made, influence=refitted))
    assert not any("--leave-out" in one for one in told)


def test_runs_that_scatter_more_than_the_intervals_say_so():
    made = with_influence(enough=True)
    wide = tuple((p.value - 9 * p.sigma, p.value + 9 * p.sigma) for p in estimated_parameters())
    found = dataclasses.replace(made.influence, interval95=wide)
    told = " ".join(said(dataclasses.replace(made, influence=found)))
    assert "friction coefficient 4.5 times" in told


def test_a_quantity_without_a_standard_error_has_no_column():
    made = with_influence()
    moved = made.influence.moved.copy()
    moved[:, 1] = np.nan
    found = dataclasses.replace(made.influence, moved=moved)
    (table, _) = influence_tables(dataclasses.replace(made, influence=found))
    assert table.header == ("without", "μ", "T 350 N")
