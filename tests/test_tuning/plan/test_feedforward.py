import equinox as eqx
import jax
import jax.numpy as jnp
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.dynamics import accelerations
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import State, driven, rest
from tuning.plan.feedforward import inverse_dynamics

SPEED = st.floats(0.1, 1.2) | st.floats(-1.2, -0.1)
RATE = st.floats(-3.0, 3.0)


@eqx.filter_jit
def volts_and_answer(robot, state, velocity, acceleration):
    voltage = inverse_dynamics(robot, state.position, velocity, acceleration)
    torque = motor_torque(robot.drive, voltage)
    answer = accelerations(robot, state, torque=torque, knock=jnp.zeros(()))
    return voltage, driven(answer)


@given(
    SPEED,
    SPEED,
    RATE,
    RATE,
    st.floats(-0.03, 0.03),
    st.sampled_from([(0.0, 0.0), (0.05, 0.0), (0.3, 0.2), (0.3, -0.2)]),
)
def test_the_commands_give_the_accelerations_that_were_wanted(v_3, v_y, a_3, a_y, lag, dry):
    # A limit that no command reaches: a clipped one can't give what was wanted.
    friction, difference = dry
    numbers = {"drive_friction": friction, "drive_friction_difference": difference}
    robot = replace(consistent(), {**numbers, "voltage_limit": 100.0})
    at = rest(robot, jnp.asarray(1.0), jnp.asarray(1.0 + lag), jnp.asarray(0.5))
    velocity = jnp.asarray([0.9 * v_3, 0.1, v_3, v_3, v_y])
    wanted = jnp.asarray([a_3, a_y])
    moving = State(at.position, velocity)
    _, answer = volts_and_answer(robot, moving, driven(velocity), wanted)
    # tanh of 50 widths is 1 to the last digit; the sums are of some 100 N.
    assert jnp.max(jnp.abs(answer - wanted)) < 1e-11


def test_each_drive_is_compensated_for_its_own_friction():
    equal = replace(consistent(), {"drive_friction": 0.3})
    unequal = replace(equal, {"drive_friction_difference": 0.2})
    at = rest(equal, *jnp.asarray([1.0, 1.0, 0.5]))
    moving = jnp.asarray([0.5, 0.0]), jnp.zeros(2)
    both, each = (volts_and_answer(robot, at, *moving)[0] for robot in (equal, unequal))
    # A tenth of a newton metre less for the first drive, a tenth more for the second.
    more = 0.1 / float(equal.drive.torque_per_volt)
    assert (each - both).tolist() == pytest.approx([-more, more], rel=1e-9)


def test_at_rest_in_line_nothing_is_commanded():
    robot = consistent()
    place = jnp.asarray(1.0)
    at = rest(robot, place, place, jnp.asarray(0.5))
    voltage, _ = volts_and_answer(robot, at, jnp.zeros(2), jnp.zeros(2))
    assert jnp.max(jnp.abs(voltage)) < 1e-12


def test_the_weight_of_the_end_effector_is_carried():
    robot = eqx.tree_at(lambda r: r.gravity, consistent(), jnp.asarray(9.81))
    place = jnp.asarray(1.0)
    at = rest(robot, place, place, jnp.asarray(0.5))
    voltage, answer = volts_and_answer(robot, at, jnp.zeros(2), jnp.zeros(2))
    lift = (
        robot.drive.torque_per_volt * (voltage[0] - voltage[1]) / robot.drive.effective_radius
    )
    assert float(lift) == pytest.approx(2.1 * 9.81, rel=1e-12)
    assert jnp.max(jnp.abs(answer)) < 1e-12


def test_the_commands_have_the_derivatives_of_their_formula():
    robot = consistent()
    place = jnp.asarray(1.0)
    at = rest(robot, place, place, jnp.asarray(0.5))

    @jax.jit
    def volts(velocity):
        return inverse_dynamics(robot, at.position, velocity, jnp.ones(2))

    check_grads(volts, (jnp.asarray([0.4, -0.3]),), order=1, modes=("fwd", "rev"))
