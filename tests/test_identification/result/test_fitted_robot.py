import pytest
from report_samples import estimate

from scdpr_jax.robot.quantities import value


def test_a_setting_has_its_own_effective_pretension():
    assert float(value(estimate().of_setting("350 N"), "effective_pretension")) == 85.0


def test_a_setting_that_no_run_had_is_refused():
    with pytest.raises(ValueError, match="no effective pretension for '200 N', got 350 N"):
        estimate().of_setting("200 N")


def test_what_is_fixed_is_not_estimated():
    fitted = estimate().fitted
    assert [p.name for p in fitted.parameters if p not in fitted.estimated] == ["frame_width"]
    assert fitted.correlation.shape == (len(fitted.estimated),) * 2
