import pathlib

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.test_util import check_grads

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.sensors import Encoder
from scdpr_jax.command.trajectory import table_3
from scdpr_jax.engines.closed_loop import (
    closed_loop,
    joint_references,
    pulley_angles,
    sampled_loop,
)
from scdpr_jax.robot.dynamics import masses
from scdpr_jax.robot.kinematics import forward_kinematics
from scdpr_jax.robot.parameters import smoothed
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import State, carriages, rest

CAMPAIGNS = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "campaigns"
ROBOT = consistent()
TRUTH = {
    "effective_pretension": 85.166460,
    "friction_coefficient": 0.018270845,
    "drive_inertia": 0.014530930,
    "drive_damping": 0.20129864,
}
"""What the campaigns' README gives for rig A."""
TIMES = 1e-3 * np.arange(4800)
COUNT = 2 * np.pi / 26624


@jax.jit
def along(trajectory):
    return jax.vmap(trajectory.position)(jnp.asarray(TIMES))


@jax.jit
def run(robot, start, reference):
    return closed_loop(robot, start, published_pd(), reference=reference, encoder=Encoder())


def placed(lower, upper, height):
    return rest(ROBOT, jnp.asarray(lower), jnp.asarray(upper), jnp.asarray(height))


@pytest.fixture(scope="module")
def horizontal():
    """The horizontal manoeuvre of Table 3 in 2 s a leg, as the campaigns' rigs ran it."""
    return along(table_3(start_time=0.2, leg_times=(2.0, 2.25, 2.5)).horizontal)


@pytest.fixture(scope="module")
def logged():
    folder = CAMPAIGNS / "rig-a" / "0005-manoeuvre"
    if not folder.exists():
        pytest.skip("the shared campaigns are not beside this repository")
    drive = np.genfromtxt(folder / "drive.csv", delimiter=",", skip_header=1)
    camera = np.genfromtxt(folder / "camera.csv", delimiter=",", skip_header=1)
    pose = camera[:, [1, 3, 4, 5, 2]] * np.array([1e-3, 1, 1e-3, 1e-3, 1e-3])
    return drive, camera[:, 0], pose


@pytest.fixture(scope="module")
def replayed(logged, horizontal):
    drive, times, pose = logged
    assert np.allclose(drive[:, 0], TIMES, rtol=0, atol=1e-9)
    # Before 0.2 s the robot rests: the mean of its first frames.
    _, _, lower, upper, height = np.nanmean(pose[times < 0.2], axis=0)
    return run(replace(ROBOT, TRUTH), placed(lower, upper, height), horizontal)


def test_loop_reproduces_a_rigs_encoders(logged, replayed):
    states = replayed.states
    moved = np.asarray(states.position - states.position[:1])
    angles = np.stack([moved[:, 2] + moved[:, 4], moved[:, 2] - moved[:, 4]], axis=1) / 0.073
    # Half a count of rounding, and another half from a start that is known to 0.1 mm only.
    assert np.abs(angles / COUNT - logged[0][:, 3:5]).max() <= 1.0


def test_loop_reproduces_a_rigs_camera_within_its_noise(logged, replayed):
    _, times, pose = logged
    seen = [np.interp(times, TIMES, coordinate) for coordinate in replayed.states.position.T]
    scatter = np.nanstd(np.stack(seen, axis=1) - pose, axis=0)
    # 0.19 mm and 2 mrad from 144 frames: within a fifth of the noise, three of its errors.
    assert np.all(scatter <= 1.2 * np.array([0.19e-3, 2e-3, 0.19e-3, 0.19e-3, 0.19e-3]))


def test_loop_reproduces_a_rigs_voltages_within_a_few_counts(logged, replayed):
    difference = np.asarray(replayed.voltage) - logged[0][:-1, 1:3]
    # One count in one period is 0.7162 V s/rad of 0.236 rad/s, 0.17 V; K_p adds 0.01 V.
    assert np.abs(difference).max() <= 2 * (0.7162 * COUNT / 1e-3 + 36.4 * COUNT)


@pytest.mark.parametrize(
    ("tension", "millimetres", "degrees"), [(350.0, 20, 0.7), (85.0, 50, 2.9), (70.0, 62, 4.0)]
)
def test_error_and_tilt_of_the_manoeuvre_tell_the_pretension(
    horizontal, tension, millimetres, degrees
):
    friction = {"effective_pretension": tension, "friction_coefficient": 4.5 / (4 * tension)}
    states = run(replace(ROBOT, friction), placed(0.3, 0.3, 0.55), horizontal).states
    deviation = np.asarray(horizontal - states.pose)
    largest = np.linalg.norm(deviation, axis=1).max()
    tilt = np.rad2deg(np.abs(states.tilt).max())
    # Whole millimetres and tenths of a degree, and half of one for the profile.
    assert abs(1e3 * largest - millimetres) <= 1.0
    assert abs(tilt - degrees) <= 0.1


def test_robot_that_is_where_it_should_be_stays():
    start = placed(0.7, 0.7, 0.5)
    found = run(ROBOT, start, jnp.tile(jnp.array([0.7, 0.5]), (TIMES.size, 1)))
    assert jnp.array_equal(found.voltage, jnp.zeros((TIMES.size - 1, 2)))
    assert jnp.array_equal(carriages(found.states.velocity), jnp.zeros((TIMES.size, 2)))
    # Nothing holds the height: the rounding of its cables' pull, 4T, may push it all along.
    push = 8 * jnp.finfo(float).eps * 4 * ROBOT.cable.effective_pretension
    assert jnp.max(jnp.abs(found.states.velocity[:, 4])) <= push / masses(ROBOT)[4] * TIMES[-1]


def test_first_reference_is_where_the_robot_is_taken_to_be():
    # Encoders are incremental: a start off the first reference isn't seen.
    reference = jnp.tile(jnp.array([0.7, 0.5]), (TIMES.size, 1))
    found = run(ROBOT, placed(0.75, 0.75, 0.4), reference)
    assert jnp.array_equal(found.voltage, jnp.zeros((TIMES.size - 1, 2)))


def test_smooth_friction_is_sent_to_the_adaptive_solvers():
    with pytest.raises(TypeError, match="exact"):
        closed_loop(
            smoothed(ROBOT), placed(1.0, 1.0, 0.5), published_pd(), reference=jnp.ones((3, 2))
        )


# The loop around integrators simple enough to know the answer.
REFERENCE = jnp.array([[0.3, 0.5], [0.31, 0.5], [0.32, 0.51], [0.33, 0.51], [0.33, 0.52]])


def stand_still(robot, state, held):
    return state


def around(advance, *, controller=None, reference=REFERENCE, **options):
    settings = {"knock": None, "encoder": None, "delay_samples": 0} | options
    controller = PD(10.0, 0.0, period=0.02) if controller is None else controller
    start = placed(0.3, 0.3, 0.5)
    return sampled_loop(advance, ROBOT, start, controller, reference=reference, **settings)


def test_command_is_computed_from_its_own_sample():
    expected = 10.0 * joint_references(ROBOT, REFERENCE)[:-1]
    assert jnp.array_equal(around(stand_still).voltage, expected)


@pytest.mark.parametrize("delay", [1, 2])
def test_delayed_commands_come_whole_periods_late(delay):
    prompt, late = around(stand_still), around(stand_still, delay_samples=delay)
    assert jnp.array_equal(late.voltage[:delay], jnp.zeros((delay, 2)))
    assert jnp.array_equal(late.voltage[delay:], prompt.voltage[:-delay])


def test_negative_delay_is_refused():
    with pytest.raises(ValueError, match=r"0 or more \[samples\], got -1"):
        around(stand_still, delay_samples=-1)


def test_command_saturates_at_the_drives_limit():
    found = around(stand_still, controller=PD(1e4, 0.0, period=0.02)).voltage
    assert jnp.array_equal(found[1], jnp.array([10.0, 10.0]))


def test_samples_are_a_period_apart():
    assert jnp.array_equal(around(stand_still).time, 0.02 * jnp.arange(5.0))


def test_knock_acts_in_its_own_interval():
    def pushed(robot, state, held):
        return State(state.position.at[0].add(held.knock), state.velocity)

    knock = jnp.array([0.0, 2.0, 0.0, 1.0])
    moved = around(pushed, knock=knock).states.position[:, 0] - 0.3
    # One rounding of a position below 4 m an addition.
    expected = jnp.array([0.0, 0.0, 2.0, 2.0, 3.0])
    assert jnp.abs(moved - expected).max() <= 4 * 4 * np.finfo(float).eps


def test_encoder_is_read_at_the_sample():
    coarse = Encoder(100.0)
    step = jnp.array([0.0, 0.0, 1e-3, 0.0, 0.0])

    def creep(robot, state, held):
        return State(state.position + step, state.velocity)

    found = around(creep, encoder=coarse).voltage
    # 1 to 3 mm are less than half of 4.6 mm a count: the first two samples see nothing yet.
    expected = 10.0 * joint_references(ROBOT, REFERENCE)[:3]
    assert jnp.array_equal(found[:3], expected)
    assert not jnp.array_equal(found[3], 10.0 * joint_references(ROBOT, REFERENCE)[3])


def test_pulleys_follow_the_lower_carriage_and_the_height():
    start = placed(0.3, 0.35, 0.5)
    moved = State(start.position + jnp.array([0.2, 0.1, 0.02, 0.3, -0.05]), start.velocity)
    back = forward_kinematics(pulley_angles(ROBOT, moved, start), jnp.asarray(0.073))
    # A few roundings of coordinates below 1 m.
    assert jnp.abs(back - jnp.array([0.02, -0.05])).max() <= 8 * np.finfo(float).eps


@pytest.mark.slow
def test_loop_around_a_smooth_integrator_is_differentiable_in_both_modes():
    # Arguments of some 1 that change little, for the checker's difference step.
    def final(gain, robot_scale, shift):
        reference = REFERENCE + 1e-2 * shift
        robot = replace(ROBOT, {"effective_radius": 0.073 * robot_scale})

        def glide(robot, state, held):
            pushed = jnp.stack([held.voltage.sum(), held.voltage[0] - held.voltage[1]])
            velocity = state.velocity.at[jnp.array([2, 4])].add(0.05 * jnp.tanh(0.1 * pushed))
            return State(state.position + held.duration * velocity, velocity)

        return sampled_loop(
            glide,
            robot,
            placed(0.3, 0.3, 0.5),
            PD(gain, 0.1, period=0.02),
            reference=reference,
            knock=None,
            encoder=None,
            delay_samples=1,
        ).states.position

    arguments = (jnp.asarray(2.0), jnp.asarray(1.0), jnp.zeros_like(REFERENCE))
    check_grads(jax.jit(final), arguments, order=1, modes=("fwd", "rev"))


SCALES = jnp.ones(4)
WEIGHTS = jnp.array([1.0, 0.5, -1.0, 2.0, 1.0])


def final_position(scales):
    numbers = {"effective_pretension": 85 * scales[0], "drive_inertia": 0.0127 * scales[1]}
    controller = PD(36.0 * scales[2], 0.7 * scales[3], 1e-3)
    pause = jnp.concatenate([jnp.linspace(0.3, 0.34, 120), jnp.full(80, 0.34)])
    reference = jnp.stack([pause, 0.5 + 0.3 * (pause - 0.3)], axis=1)
    start = placed(0.3, 0.299, 0.5)
    found = closed_loop(replace(ROBOT, numbers), start, controller, reference=reference)
    return found.states.position[-1]


@pytest.fixture(scope="module")
def gradient():
    weighted = jax.jit(jax.value_and_grad(lambda scales: WEIGHTS @ final_position(scales)))
    _, found = weighted(SCALES)
    differences = [
        (weighted(SCALES + 1e-6 * unit)[0] - weighted(SCALES - 1e-6 * unit)[0]) / 2e-6
        for unit in jnp.eye(4)
    ]
    return found, jnp.stack(differences)


@pytest.mark.slow
def test_reverse_derivatives_hold_through_stick_and_slip_under_control(gradient):
    found, differences = gradient
    # Roundings of some 10 ulp of 1 m over 2e-6. Above a relative step of 1e-5 an event moves
    # into another period, where the derivative changes by 6e-6.
    assert jnp.abs(found - differences).max() <= 10 * np.finfo(float).eps / 1e-6
    assert jnp.abs(found).min() > 1e-3


@pytest.mark.slow
def test_forward_derivatives_hold_through_stick_and_slip_under_control(gradient):
    found, _ = gradient
    direction = jnp.array([1.0, -2.0, 0.5, 1.0])
    _, slope = jax.jit(lambda scales: jax.jvp(final_position, (scales,), (direction,)))(SCALES)
    # The same derivative, summed in another order.
    assert jnp.abs(WEIGHTS @ slope - found @ direction) <= 1e4 * np.finfo(float).eps


def test_loop_has_one_fewer_command_than_samples():
    found = eqx.filter_eval_shape(run, ROBOT, placed(0.3, 0.3, 0.5), REFERENCE)
    assert found.voltage.shape == (4, 2)
    assert found.states.position.shape == (5, 5)
