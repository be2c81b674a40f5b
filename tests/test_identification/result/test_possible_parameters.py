"""A `parameters.json` that can't be a robot is refused, with one message."""

import json

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hostile_documents import outcomes
from report_samples import complete, estimate

import scdpr_jax
from identification.result.parameters_file import read_parameters, write_parameters
from scdpr_jax.robot.quantities import EVERY_QUANTITY, value
from scdpr_jax.robot.stated.ranges import check_value


@pytest.fixture(scope="module")
def document(tmp_path_factory):
    path = tmp_path_factory.mktemp("good") / "parameters.json"
    write_parameters(path, complete(estimate()))
    written = json.loads(path.read_text())
    # What a robot is built from: the rest isn't read.
    return {key: written[key] for key in ("format", "parameters", "correlation")}


def read(document, path):
    path.write_text(json.dumps(document))
    return read_parameters(path)


def row_of(document, name):
    return next(row for row in document["parameters"] if row["name"] == name)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"value": -2.1}, r"`end_effector_mass` can't be a robot's, got -2.1 kg"),
        ({"value": 2070000.0}, r"can't be a robot's, got 2.07e\+06 kg, expected 0.0001 to"),
        ({"value": "2.07"}, "value is wrong, got '2.07'"),
        ({"value": float("nan")}, r"value is wrong, got nan"),
        ({"value": None}, r"value is wrong"),
        ({"unit": "g"}, r"the unit of 'end_effector_mass' is wrong, got 'g'"),
        ({"name": "end_effector_mas"}, r"parameters are missing, .* without end_effector_mass"),
        ({"name": "frame_width", "unit": "m"}, r"missing|twice"),
        ({"sigma": -1.0}, r"the errors of `end_effector_mass` can't be, got sigma -1"),
        ({"interval95": [3.0, 1.0]}, r"an interval from 3 to 1 \[kg\]"),
    ],
)
def test_what_can_not_be_is_refused_with_the_file(document, tmp_path, change, told):
    broken = json.loads(json.dumps(document))
    row_of(broken, "end_effector_mass").update(change)
    with pytest.raises(ValueError, match=rf"parameters\.json: .*{told}|parameters.*{told}"):
        read(broken, tmp_path / "parameters.json")


def test_parameters_that_are_there_twice_are_refused(document, tmp_path):
    broken = document | {"parameters": [*document["parameters"], document["parameters"][0]]}
    with pytest.raises(ValueError, match=r"there twice, got friction_coefficient"):
        read(broken, tmp_path / "parameters.json")


def test_an_end_effector_higher_than_its_frame_is_refused(document, tmp_path):
    broken = json.loads(json.dumps(document))
    row_of(broken, "upper_offset")["value"] = 1.2
    with pytest.raises(ValueError, match=r"`lower_offset` \+ `upper_offset` can't be"):
        read(broken, tmp_path / "parameters.json")


def test_a_correlation_that_is_none_is_refused(document, tmp_path):
    broken = json.loads(json.dumps(document))
    broken["correlation"]["matrix"][0][1] = 3.0
    with pytest.raises(ValueError, match=r"the correlation can't be"):
        read(broken, tmp_path / "parameters.json")


@jax.jit
def swing(robot):
    """A tenth of a second of a robot that a drive pulls away."""
    place = jnp.asarray(0.3)
    start = scdpr_jax.rest(robot, place, place, 0.5 * robot.frame.height)
    inputs = scdpr_jax.Inputs(np.full(20, 5e-3), np.full((20, 2), 1.0), np.zeros(20))
    return scdpr_jax.simulate(robot, start, inputs).position


def check_moves(fitted):
    """Every number is one that a robot may have, and a run of it has no NaN."""
    for quantity in EVERY_QUANTITY:
        if quantity.name != "stribeck_velocity":  # stands for nothing without a surplus
            check_value(quantity.name, float(value(fitted.robot, quantity.name)))
    assert np.isfinite(swing(fitted.robot)).all()


def refusals(document, path, *, seed, draws):
    """Reasons of hostile files; what isn't refused is a robot that moves."""
    made = outcomes(read_parameters, document, path, seed=seed, draws=draws, judge=check_moves)
    reasons = [reason for reason in made if reason is not None]
    assert all(reason.startswith(f"{path}: ") and "got" in reason for reason in reasons)
    return reasons


def test_hostile_files_give_a_robot_or_a_reason(document, tmp_path):
    assert len(refusals(document, tmp_path / "parameters.json", seed=1, draws=60)) > 10


@pytest.mark.slow
def test_a_thousand_hostile_files_give_a_robot_or_a_reason(document, tmp_path):
    assert len(refusals(document, tmp_path / "parameters.json", seed=2, draws=1000)) > 200
