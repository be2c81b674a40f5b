import math

import pytest
from report_samples import TRUTH, estimate

from experiments.studies.findings.parameters import covers, friction_forces


def test_the_friction_force_is_surer_than_its_two_factors():
    (force,) = friction_forces(estimate())
    assert force.force == pytest.approx(4 * 85.0 * 0.013, rel=1e-12)  # two multiplications
    mu, tension = 1e-5 / 0.013, 0.05 / 85.0
    sigma = force.force * math.sqrt(mu**2 + tension**2 - 2 * 0.97 * mu * tension)
    # The normal distribution's factor for 95 %, to its printed digits.
    assert force.half_width == pytest.approx(1.95996 * sigma, rel=1e-5)


def test_coverage_is_judged_at_the_wider_level():
    assert not covers(estimate(), TRUTH)
    # 2.9 standard errors: outside 95 %, inside 99.7 % (2.968 of them).
    assert covers(estimate(), {"effective_pretension": 85.0 + 2.9 * 0.05})
