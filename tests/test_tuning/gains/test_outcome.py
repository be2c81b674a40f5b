"""What legs come to, judged as they run."""

import jax
import numpy as np
import pytest

from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.command.trajectory import rest_to_rest
from scdpr_jax.legs.command_law import CommandLaw
from scdpr_jax.legs.leg import run_leg
from scdpr_jax.legs.random_legs import random_legs
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.gains.legs import PERIOD, legs_of, plain_law
from tuning.gains.outcome import HOLD, outcome
from tuning.gains.regional import told
from tuning.result.prediction import LegsOutcome

ROBOT = exact(consistent())
ROBOTS = [ROBOT, replace(ROBOT, {"effective_pretension": 200.0, "drive_friction": 0.05})]
LEGS = legs_of(ROBOTS, random_legs(ROBOT.frame, 40, seed=5))
SHAPERS = (
    Shaper([0.0], [1.0]),
    Shaper([0.0, 0.15], [0.5, 0.5]),
    Shaper([0.0, 0.3, 1.2], [0.57, 0.47, -0.04]),
    Shaper([0.0, 0.1, 0.2, 1.7], [0.3, 0.3, 0.2, 0.2]),
)
LAWS = told(PD(18.0, 0.75), SHAPERS * 10, legs=[1] * len(LEGS))


@pytest.fixture(scope="module")
def found():
    return outcome(LEGS, LAWS)


def of_traces(legs, laws):
    """Both numbers as `scdpr_jax.legs.measures` takes them from traces of whole legs."""

    @jax.jit
    def measures(own, law):
        reference = rest_to_rest(own.ensemble.position, own.end, duration=own.time)
        commands = CommandLaw(reference, law.controller, law.shaper).commands(
            2700, judged=round(HOLD / PERIOD)
        )
        made = run_leg(own.ensemble.robot, own.ensemble.start, commands).measures
        return made.residual_vibration, made.resting_error

    return LegsOutcome(*map(np.asarray, jax.vmap(measures)(legs, laws)))


def test_legs_come_to_what_their_traces_measure(found):
    traces = of_traces(LEGS, LAWS)
    np.testing.assert_allclose(found.vibration, traces.vibration, rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.resting_error, traces.resting_error, rtol=0, atol=1e-11)


def test_what_runs_beside_a_leg_changes_no_bit_of_it(found):
    rows = np.array([31, 4, 17])
    some = outcome(LEGS.rows(rows), jax.tree.map(lambda leaf: leaf[rows], LAWS))
    np.testing.assert_array_equal(some.vibration, found.vibration[rows])
    np.testing.assert_array_equal(some.resting_error, found.resting_error[rows])


def test_one_law_is_told_to_all_legs():
    each = jax.tree.map(lambda leaf: np.stack([np.asarray(leaf)] * len(LEGS)), plain_law())
    np.testing.assert_array_equal(
        outcome(LEGS, plain_law()).vibration, outcome(LEGS, each).vibration
    )
