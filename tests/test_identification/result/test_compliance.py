"""The give of cables between drives and carriage, from rigs of another program."""

import numpy as np
import pytest
from leg_rigs import campaign, draw_rig, needs_compiler

from identification.data.circumstances import NAMES, Circumstances
from identification.result.compliance import compliance
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace

pytestmark = needs_compiler


def measured(seed, *, elastic):
    rig = draw_rig(seed, elastic=elastic)
    numbers = {
        "effective_pretension": rig.pretension,
        "friction_coefficient": rig.lower_friction,
        "drive_inertia": rig.inertia,
        "drive_damping": rig.damping,
        "drive_friction": rig.motor_friction,
    }
    logged = campaign(rig, seed)
    clocks = {run.name: Circumstances.of(np.zeros(len(NAMES))) for run in logged.runs}
    return compliance(logged, exact(replace(consistent(), numbers)), clocks), rig


@pytest.mark.parametrize("seed", [401, 402, 403, 404])
def test_cables_that_give_are_measured(seed):
    (value, sigma), rig = measured(seed, elastic=True)
    # Two cables side by side; backlash counts as give, up to 0.15 mm under some 20 N.
    true = 1 / (2 * rig.cable_stiffness)
    assert abs(value - true) < 4 * sigma + rig.backlash / 2 / 20
    assert sigma < 4e-6


@pytest.mark.parametrize("seed", [401, 402, 403, 404, 405, 406])
def test_rigid_cables_count_as_rigid(seed):
    assert measured(seed, elastic=False)[0] is None
