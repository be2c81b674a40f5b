from report_samples import compared_models, estimate

from experiments.reports.model_tables import model_tables, moved_table


def test_a_usual_model_that_is_enough_is_not_compared():
    assert model_tables(estimate()) == ()


def test_the_chosen_model_is_marked_and_the_others_are_held_against_it():
    (table,) = model_tables(estimate(models=compared_models()))
    assert [row[0].endswith("chosen") for row in table.rows] == [False, True]
    assert [row[3] for row in table.rows] == ["+190", "+0"]


def test_every_sensor_of_a_run_that_anything_moves_has_a_row():
    found = estimate().identifiability
    assert [row[:2] for row in moved_table(found).rows][:2] == [
        ("0001-manoeuvre", "encoders"),
        ("0001-manoeuvre", "camera"),
    ]
