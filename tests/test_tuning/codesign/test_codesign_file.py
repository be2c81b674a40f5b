"""A made-up co-design, written and read."""

import json

import numpy as np
import pytest
from codesign_samples import LAW, co_design
from hostile_documents import outcomes

from tuning.codesign.codesign_file import read_law, write_codesign
from tuning.result.document import read_tuning


def test_the_recommended_law_that_is_written_is_read(tmp_path):
    write_codesign(tmp_path / "codesign.json", co_design())
    again = read_law(tmp_path / "codesign.json")
    for name in ("profile", "leg_time"):
        np.testing.assert_array_equal(getattr(again, name), getattr(LAW, name))
    np.testing.assert_array_equal(again.shaper.times, LAW.shaper.times)
    np.testing.assert_array_equal(again.shaper.amplitudes, LAW.shaper.amplitudes)
    np.testing.assert_array_equal(
        again.controller.derivative_gain, LAW.controller.derivative_gain
    )


def test_a_co_design_is_a_tuning_to_plan_with(tmp_path):
    write_codesign(tmp_path / "codesign.json", co_design())
    tuning = read_tuning(tmp_path / "codesign.json")
    assert float(tuning.controller.derivative_gain) == float(LAW.controller.derivative_gain)
    np.testing.assert_array_equal(
        tuning.shaper_at(1.0, 0.5, 349.9).shaper.times, LAW.shaper.times
    )
    assert tuning.robot_at(350.0).pretension == 350.0


def test_the_file_tells_the_worst_and_the_mean_of_the_models(tmp_path):
    write_codesign(tmp_path / "codesign.json", co_design())
    document = json.loads((tmp_path / "codesign.json").read_text())
    assert document["vibration"] == {
        "worst_tenth": 2e-3,
        "worst": 2e-3,
        "mean": 1.5e-3,
        "unit": "m",
    }
    assert document["models"]["count"] == 2
    assert document["margins"]["flexible"][1]["value"] is None


@pytest.mark.parametrize(
    ("break_it", "told"),
    [
        (
            lambda d: d["controller"].pop("period"),
            "controller.period is missing, got no such key",
        ),
        (lambda d: d.update(format=2), "format is wrong"),
        (lambda d: d["controller"]["derivative_gain"].update(value=-1.0), "value is wrong"),
        (lambda d: d["controller"]["derivative_gain"].update(unit="V/rad"), "unit is wrong"),
        (lambda d: d["shaper"].update(amplitudes=[0.4, 0.3, 0.2, 0.2]), "sum to 1.1"),
        (lambda d: d["leg"]["duration"].update(value=float("inf")), "value is wrong"),
    ],
)
def test_a_broken_file_is_refused_with_its_place(break_it, told, tmp_path):
    path = tmp_path / "codesign.json"
    write_codesign(path, co_design())
    document = json.loads(path.read_text())
    break_it(document)
    path.write_text(json.dumps(document))
    with pytest.raises(ValueError, match=told):
        read_law(path)


def check_usable(law):
    numbers = [*law.shaper.times, *law.profile, law.leg_time, law.controller.derivative_gain]
    assert np.all(np.isfinite(np.asarray(numbers, dtype=float)))
    assert float(law.leg_time) >= 0
    assert float(law.controller.period) > 0


def test_hostile_files_give_a_law_or_a_reason(tmp_path):
    path = tmp_path / "codesign.json"
    write_codesign(path, co_design())
    written = json.loads(path.read_text())
    document = {name: written[name] for name in ("format", "controller", "shaper", "leg")}
    made = outcomes(read_law, document, path, seed=1, draws=200, judge=check_usable)
    reasons = [reason for reason in made if reason is not None]
    assert len(reasons) > 100
    assert all(reason.startswith(f"{path}: ") and "got" in reason for reason in reasons)


@pytest.mark.parametrize(("volts", "holds"), [(9.99, True), (10.0, False)])
def test_a_design_holds_where_unseen_robots_keep_the_drives_limit(volts, holds):
    assert co_design(volts=volts).holds == holds


def test_a_co_design_says_what_it_is_for_and_what_it_comes_to():
    text = repr(co_design())
    assert "1 x 2 poses, 1 robots at 350 N" in text
    assert "worst tenth vibrates 2 mm" in text
    assert "worst tenth 3 mm; margins and voltage kept" in text
    assert len(text.splitlines()) == 3


def test_a_co_design_of_a_failed_fit_is_marked(tmp_path):
    write_codesign(tmp_path / "codesign.json", co_design(), caution="CAUTION: mind it.")
    document = json.loads((tmp_path / "codesign.json").read_text())
    assert document["caution"] == "CAUTION: mind it."
