import dataclasses

import pytest
from report_samples import compared_models, estimate

from identification.fit.unknowns.measured import MeasuredQuantity
from identification.fit.unknowns.options import FitOptions
from scdpr_jax.robot.quantities import value


def test_an_estimate_tells_its_quantities_in_a_few_lines():
    lines = repr(estimate(models=compared_models())).splitlines()
    assert lines[0].startswith("Estimate from 3 runs, 1 predicted: converged")
    assert "effective_pretension 350 N = 85 N ± 0.05 N, identified" in lines[3]
    assert lines[4].endswith("a tension that rises as the loop's path gets longer")
    assert len(lines) == 5


def test_what_was_measured_otherwise_stands_beside_the_fits_value():
    tension = MeasuredQuantity(
        quantity="effective_pretension", value=84.0, sigma=0.5, setting="350 N"
    )
    mass = MeasuredQuantity(quantity="end_effector_mass", value=1.0, sigma=0.1)
    options = FitOptions(measured=[tension, mass])
    first, second = dataclasses.replace(estimate(), options=options).measured_fits
    assert (first.value, first.deviation) == pytest.approx((85.0, 2.0))
    own = float(value(estimate().robot, "end_effector_mass"))
    assert (second.value, second.deviation) == pytest.approx((own, (own - 1.0) / 0.1))
