import numpy as np
import pytest

from experiments.studies.codesign.run import parse_grid
from experiments.studies.posterior import draw, nominal_settings
from identification.result.parameters_file import ParametersDocument

FITTED = ParametersDocument.model_validate(
    {
        "format": 1,
        "parameters": [
            {
                "name": name,
                "setting": setting,
                "value": value,
                "unit": unit,
                "sigma": sigma,
                "status": "identified" if sigma else "fixed",
            }
            for name, setting, value, unit, sigma in (
                ("effective_pretension", "350 N", 85.0, "N", 0.85),
                ("friction_coefficient", None, 0.018, "1", 0.00018),
                ("drive_inertia", None, 0.0145, "kg m^2", None),
            )
        ],
        "correlation": {
            "names": ["effective_pretension 350 N", "friction_coefficient"],
            "matrix": [[1.0, -0.8], [-0.8, 1.0]],
        },
    }
).fitted_robot()


@pytest.fixture(scope="module")
def drawn():
    robots = draw(FITTED, (350.0,), count=400, seed=3)
    return np.array(
        [
            (float(r.cable.effective_pretension), float(r.lower_carriage.friction.coefficient))
            for r in robots
        ]
    )


def test_samples_have_the_fits_errors(drawn):
    # 400 samples: standard errors to 3.5 %, three times that at the most.
    np.testing.assert_allclose(drawn.std(axis=0) / (0.85, 0.00018), 1.0, atol=0.11)


def test_samples_are_correlated_as_the_fit_says(drawn):
    assert abs(np.corrcoef(drawn.T)[0, 1] + 0.8) < 0.06


def test_what_has_no_known_error_keeps_its_value():
    robots = draw(FITTED, (350.0,), count=3, seed=1)
    assert {float(r.drive.inertia) for r in robots} == {0.0145}


def test_a_setting_that_was_not_fitted_has_its_tension_in_proportion():
    near, far = draw(FITTED, (350.0, 500.0), count=1, seed=1)
    ratio = float(far.cable.effective_pretension / near.cable.effective_pretension)
    np.testing.assert_allclose(ratio, 500 / 350)


def test_the_same_seed_draws_the_same_robots():
    first, second = (draw(FITTED, (350.0,), count=2, seed=9) for _ in range(2))
    assert [float(r.cable.effective_pretension) for r in first] == [
        float(r.cable.effective_pretension) for r in second
    ]


def test_fitted_settings_are_read_off():
    assert nominal_settings(FITTED) == (350.0,)


@pytest.mark.parametrize("text", ["4", "4x", "0x5", "4x1", "four by five"])
def test_a_grid_that_is_none_is_refused(text):
    with pytest.raises(ValueError, match="--grid"):
        parse_grid(text)


def test_a_grid_is_columns_by_rows():
    assert parse_grid("4x5") == (4, 5)
