import numpy as np
import pytest

from experiments.virtual_rig import recovery
from identification.checks.selection import _choice, _score, select
from identification.fit.unknowns.models import Model
from scdpr_jax.numerics.merit import Normal
from scdpr_jax.robot.quantities import replace


def test_the_score_is_the_fall_of_the_misfit_where_the_problem_is_linear():
    random = np.random.default_rng(2)
    matrix, target = random.normal(size=(30, 4)), random.normal(size=30)
    base = np.eye(4)[:, :2]
    found = np.linalg.lstsq(matrix[:, :2], target, rcond=None)[0]
    residual = matrix[:, :2] @ found - target
    normal = Normal(residual @ residual, matrix.T @ residual, matrix.T @ matrix)
    whole = np.linalg.lstsq(matrix[:, :3], target, rcond=None)[0]
    left = matrix[:, :3] @ whole - target
    np.testing.assert_allclose(
        _score(normal, base, [2]), residual @ residual - left @ left, rtol=1e-10
    )


def model(bic, held_out):
    return Model((), ("drive_inertia",), 1.0, 0.0, bic, held_out, held_out)


def test_held_out_runs_decide_where_there_are_any():
    assert _choice([model(100.0, 7.0), model(90.0, 3.0), model(80.0, 5.0)]) == 1


def test_schwarzs_criterion_decides_where_there_are_none():
    assert _choice([model(100.0, None), model(90.0, None), model(95.0, None)]) == 1


@pytest.mark.slow
def test_what_a_rig_has_beyond_the_usual_model_is_named():
    truth = recovery.draw(7)
    values = {"loop_stiffness": 2000.0, "drive_friction": 0.05}
    rig = truth._replace(robot=replace(truth.robot, values))
    found = select(recovery.campaign(rig, 7))
    assert "a tension that rises as the loop's path gets longer" in found.lacks
    by_name = {p.name: p for p in found.parameters}
    for name, number in values.items():
        assert abs(by_name[name].value / number - 1) < 0.02
