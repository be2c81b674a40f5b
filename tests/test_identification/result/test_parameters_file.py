import dataclasses
import json
import math

import numpy as np
import pytest
from report_samples import complete, estimate, parameter

from identification.data.circumstances import BEGINNING, Circumstances
from identification.result.parameters_file import (
    ParametersDocument,
    read_parameters,
    write_parameters,
)


def test_a_fitted_robot_comes_back_from_its_file(tmp_path):
    path, made = tmp_path / "parameters.json", complete(estimate())
    write_parameters(path, made)
    fitted = read_parameters(path)
    assert fitted.parameters == made.parameters
    np.testing.assert_array_equal(fitted.correlation, made.correlation)
    channels = [channel for run in made.comparisons for channel in run.channels]
    assert [r.channel for r in fitted.residuals] == [c.name for c in channels]
    assert [r.is_noise for r in fitted.residuals] == [c.is_noise for c in channels]


def test_what_has_no_error_is_null_in_the_file_and_infinite_in_a_program(tmp_path):
    path = tmp_path / "parameters.json"
    unseen = parameter("drive_damping", 0.2, math.inf, unit="N m s", status="unidentifiable")
    made = estimate()
    parameters = (*made.parameters[:2], unseen)
    fitted = dataclasses.replace(made.fitted, parameters=parameters)
    write_parameters(path, complete(dataclasses.replace(made, fitted=fitted)))
    assert json.loads(path.read_text())["parameters"][2]["sigma"] is None
    assert read_parameters(path).parameters[2].sigma == math.inf


def test_start_velocities_of_a_run_in_motion_are_in_the_file(tmp_path):
    path, made = tmp_path / "parameters.json", complete(estimate())
    speeds = (1e-3, 0.02, 0.3, -0.5, 0.2, 3.0, 2.5)
    name = made.comparisons[0].name
    begun = Circumstances.of(np.array([1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0, *speeds]))
    write_parameters(path, dataclasses.replace(made, circumstances={name: begun}))
    run, *others = json.loads(path.read_text())["runs"]
    assert run["beginning"] == dict(zip(BEGINNING, speeds, strict=True))
    assert [other["beginning"] for other in others] == [None] * len(others)


def document(names, matrix):
    rows = [
        {"name": name, "setting": None, "value": 1.0, "unit": unit, "status": "identified"}
        for name, unit in (("friction_coefficient", "1"), ("drive_inertia", "kg m^2"))
    ]
    correlation = {"names": names, "matrix": matrix}
    return {"format": 1, "parameters": rows, "correlation": correlation}


def test_a_correlation_in_another_order_is_put_into_that_of_the_parameters():
    names = ["drive_inertia", "friction_coefficient"]
    made = ParametersDocument.model_validate(document(names, [[1.0, 0.3], [0.4, 1.0]]))
    np.testing.assert_array_equal(made.fitted_robot().correlation, [[1.0, 0.4], [0.3, 1.0]])


def test_a_correlation_of_other_parameters_is_not_known():
    made = ParametersDocument.model_validate(document(["drive_inertia"], [[1.0]]))
    assert made.fitted_robot().correlation is None


def test_a_value_in_another_unit_is_refused_with_the_file(tmp_path):
    path = tmp_path / "parameters.json"
    wrong = document(["drive_inertia", "friction_coefficient"], [[1.0, 0.0], [0.0, 1.0]])
    wrong["parameters"][1]["unit"] = "kg cm^2"
    path.write_text(json.dumps(wrong))
    with pytest.raises(ValueError, match=r"parameters\.json: the unit of 'drive_inertia'"):
        read_parameters(path)
