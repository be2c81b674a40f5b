from report_samples import compared_models, estimate

from experiments.studies.findings.models import combination_sentences, model_sentences


def test_of_a_usual_model_that_is_enough_nothing_is_said():
    assert model_sentences(estimate()) == ()


def test_the_verdict_names_what_the_usual_model_lacks_and_what_that_is_worth():
    (told,) = model_sentences(estimate(models=compared_models()))
    assert "lacks a tension that rises as the loop's path gets longer" in told
    assert "2.30 mm rms, the usual one to 7.70 mm" in told


def test_what_the_logs_cannot_tell_is_said_in_words():
    (told,) = combination_sentences(estimate().identifiability)
    assert told.startswith("These logs can't tell")
    assert "35 %" in told
