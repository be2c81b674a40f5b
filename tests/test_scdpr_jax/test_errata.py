"""The printed forms against what the product uses; `docs/errata.md` has a row for each.

Errata that a module's own tests hold already are not repeated here.
"""

import pathlib
import re

import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st

from scdpr_jax.command.controller import published_pd
from scdpr_jax.engines import stepping
from scdpr_jax.engines.closed_loop import closed_loop
from scdpr_jax.linear.model import external_forces, mass_matrix
from scdpr_jax.linear.stiffness import cable_lengths
from scdpr_jax.robot.cable import loop_forces, paths, potential
from scdpr_jax.robot.drive import drive_pole, motor_torque, transfer_function
from scdpr_jax.robot.dynamics import drive_forces, pulley_rates
from scdpr_jax.robot.loop_elasticity import (
    consistent_section,
    loop_stiffness,
    published_section,
)
from scdpr_jax.robot.prototype import consistent, published
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import TILT, pose, rest
from scdpr_jax.statics.workspace import frame_share, static_workspace

ROOT = pathlib.Path(__file__).parents[2]
EPS = float(np.finfo(float).eps)
ROBOT = consistent()
TENSION, RADIUS = 85.0, 0.073
BREAKAWAY = 2 * 0.3284 / RADIUS
"""Force of both drives when the robot begins to move, section 5.1 [N]."""

# Experiment 1 of Table 2: 4.85 N m on both drives for a second, then a coast to rest.
PERIOD, INTERVALS = 1e-3, 2500
TORQUE = np.where((np.arange(INTERVALS) < 1000)[:, None], np.full(2, 4.85), 0.0)


@jax.jit
def simulated(robot, voltage):
    start = rest(robot, jnp.asarray(0.173), jnp.asarray(0.173), jnp.asarray(0.3))
    inputs = stepping.Inputs(
        jnp.full(INTERVALS, PERIOD), voltage, jnp.zeros(INTERVALS, dtype=voltage.dtype)
    )
    return stepping.simulate(robot, start, inputs).position


def experiment_1(**numbers):
    """Positions of a consistent robot with some other numbers; the limit is lifted, see E20."""
    robot = replace(ROBOT, {"voltage_limit": 100.0, **numbers})
    return simulated(robot, jnp.asarray(TORQUE / 0.482))


@pytest.fixture(scope="module")
def consistent_run():
    return experiment_1()


def test_printed_radius_lets_experiment_1_move_by_a_sixth_of_a_metre_at_most():
    travel = float(experiment_1(effective_radius=7.3e-3)[1000, 0]) - 0.173
    # Damping alone allows r tau / b for one second; the experiment is to cross the frame.
    assert 0.1 < travel < 7.3e-3 * 4.85 / 0.2124


def test_consistent_radius_takes_experiment_1_across_the_frame_and_no_further(consistent_run):
    assert consistent_run[-1, 0] > 1.6
    assert static_workspace(ROBOT).contains(pose(consistent_run[-1]))


rate = st.floats(-2, 2)
torque = st.floats(-5, 5)


@hypothesis.given(rate, rate, torque, torque)
def test_the_two_radii_are_one_or_power_would_be_lost(sideways, upwards, first, second):
    velocity = jnp.array([0.1, 0.2, sideways, -0.3, upwards])
    torques = jnp.array([first, second])
    delivered = jnp.sum(torques * pulley_rates(ROBOT, velocity))
    received = jnp.sum(drive_forces(ROBOT, torques) * velocity)
    # Some ten roundings of the largest power.
    assert jnp.abs(delivered - received) <= 16 * EPS * 4 * 5 * 2 / RADIUS


POSE = jnp.array([1.0, 0.1, 1.05, 0.93, 0.4])
LOWER, UPPER = 0.12, 0.16
OFFSET = replace(ROBOT, {"lower_offset": LOWER, "upper_offset": UPPER})


def work(arm_of_upper, *, move, turn):
    """Work of Eq. (14)'s forces on A and B, with B's horizontal arm as given, Eq. (12)."""
    (sin_a, cos_a), (sin_b, cos_b) = (np.array(p.direction) for p in paths(OFFSET, POSE)[:2])
    sine, cosine = np.sin(0.1), np.cos(0.1)
    at_lower = [move + LOWER * cosine * turn, LOWER * sine * turn]
    at_upper = [move + arm_of_upper * cosine * turn, -UPPER * sine * turn]
    pull_of_lower, pull_of_upper = [sin_a, -cos_a], [-sin_b, cos_b]
    return 2 * TENSION * (np.dot(pull_of_lower, at_lower) + np.dot(pull_of_upper, at_upper))


def test_equation_13_gives_equation_16_with_a_minus_only():
    moment = float(loop_forces(OFFSET, POSE).pull[1])
    # A few roundings of 2T times an arm below 0.2 m.
    assert abs(work(-UPPER, move=0.0, turn=1.0) - moment) <= 16 * EPS * 2 * TENSION
    assert abs(work(UPPER, move=0.0, turn=1.0) - moment) > 1.0


def test_equation_15_is_the_work_of_equation_16_with_a_product_only():
    pull = np.asarray(loop_forces(OFFSET, POSE).pull)
    sine = float(paths(OFFSET, POSE).alpha.direction[0])
    move, turn = 0.01, 0.02
    product = work(-UPPER, move=move, turn=turn)
    printed = product + 2 * TENSION * (sine + move - sine * move)
    expected = pull[0] * move + pull[1] * turn
    # A few roundings of 2T times the displacements.
    assert abs(product - expected) <= 16 * EPS * 2 * TENSION * 0.02
    assert abs(printed - expected) > 1.0


def test_equation_10_pulls_back_with_a_minus_only():
    # A Lagrangian that has the potential in it, of an end-effector to the right of its line.
    aside = jnp.array([1.02, 0.0, 1.0, 1.0, 0.4])
    by_position = jax.grad(lambda q: -potential(ROBOT, q))(aside)[0]
    pull = loop_forces(ROBOT, aside).pull[0]
    # M a - dL/dq = 0 is the pull; the printed M a + dL/dq = 0 would drive it away.
    assert jnp.abs(by_position - pull) <= 16 * EPS * 2 * TENSION
    assert pull < 0 < -by_position


def test_equation_21_as_printed_exceeds_coulomb_friction():
    velocity = jnp.array([0.1, 0.0, 0.4, 0.4])
    used = -external_forces(ROBOT, velocity, torque=jnp.zeros(2))[2]
    limit = 4 * TENSION * ROBOT.lower_carriage.friction.coefficient
    printed = limit * velocity[2] / jnp.abs(velocity[0])
    assert jnp.abs(used - limit) <= 4 * EPS * limit
    assert printed > 3.9 * limit


def test_printed_damping_has_another_pole_than_equation_24():
    # 16.68 1/s to two decimals.
    assert abs(float(drive_pole(published().drive)) - 16.68) > 0.9
    assert abs(float(drive_pole(ROBOT.drive)) - 16.68) <= 0.005


def test_breakaway_torque_lies_between_its_two_printed_values():
    assert 0.3268 < float(motor_torque(ROBOT.drive, jnp.asarray(0.68))) < 0.3284


def test_nameplate_chain_gives_neither_breakaway_torque_nor_gain():
    nameplate, fitted = published().drive.torque_per_volt, ROBOT.drive.torque_per_volt
    # Given as 2.3 %.
    assert abs(float(1 - nameplate / fitted) - 0.023) <= 0.0005
    assert float(motor_torque(published().drive, jnp.asarray(0.68))) < 0.3268


@pytest.mark.parametrize("robot", [consistent(), published()], ids=["k_v", "nameplates"])
def test_drives_at_their_limit_give_less_than_experiment_1s_torque(robot):
    assert motor_torque(robot.drive, jnp.asarray(10.0)) < 4.85


def test_controller_on_radians_would_cross_over_far_below_forty():
    jw = 40j
    plant = complex(transfer_function(ROBOT.drive).response(jnp.asarray(40.0)))
    printed = abs((0.6352 + 0.0125 * jw) * plant)
    # On degrees the loop gain at 40 rad/s is one, within what 40.31 rad/s makes of it.
    assert abs(np.rad2deg(printed) - 1) <= 0.02
    assert printed < 0.02


def test_printed_friction_holds_the_robot_against_both_drives_at_their_limit():
    held = replace(ROBOT, {"friction_coefficient": 0.1723, "effective_pretension": 350.0})
    position = simulated(held, jnp.asarray(np.full((INTERVALS, 2), 10.0)))
    assert jnp.array_equal(position, jnp.broadcast_to(position[0], position.shape))


def test_consistent_friction_is_the_breakaway_force_and_the_printed_one_is_not():
    def both_carriages(tension, coefficient):
        return 2 * 4 * tension * coefficient

    coefficient = float(ROBOT.lower_carriage.friction.coefficient)
    # 9.0 N, two digits.
    assert abs(both_carriages(TENSION, coefficient) - BREAKAWAY) <= 0.05
    assert both_carriages(350.0, 0.1723) > 50 * BREAKAWAY


def test_masses_of_equation_19_would_run_experiment_1_out_of_the_frame(consistent_run):
    moving = jnp.sum(jnp.diagonal(mass_matrix(ROBOT))[jnp.array([0, 2, 3])])
    force = 2 * 4.85 / RADIUS - BREAKAWAY
    # Half a t squared in one second.
    assert force / moving / 2 > 6 * ROBOT.frame.width
    assert consistent_run[1000, 0] - 0.173 < ROBOT.frame.width


def test_bare_steel_loop_would_gain_many_times_its_pretension(consistent_run):
    moving = jax.vmap(lambda q: 2 * sum(path.length for path in paths(ROBOT, q)))
    lengths = moving(consistent_run)
    # E A over the loop's length: 2 mm of solid steel along the moving paths and the frame.
    stiffness = 209.12e9 * np.pi * 1e-3**2 / (float(lengths[0]) + 2 * 2.224)
    assert stiffness * float(jnp.max(lengths) - lengths[0]) > 10 * TENSION


def test_appendix_with_inverse_sines_puts_the_attachment_elsewhere():
    upright = jnp.array([1.0, 0.0, 1.0, 1.0, 0.4])
    used = float(paths(OFFSET, upright).alpha.vertical)
    assert abs(used - (0.4 - LOWER)) <= 2 * EPS
    assert abs(used - (0.4 - LOWER * np.arccos(0.0))) > 0.5 * LOWER


def test_horizontal_manoeuvre_at_its_printed_time_a_leg_errs_by_half_of_what_is_reported():
    share = np.clip((PERIOD * np.arange(4500) - 0.2) / 4.0, 0, 1)
    across = 0.3 + 1.6 * (3 * share**2 - 2 * share**3)
    reference = jnp.asarray(np.stack([across, np.full_like(across, 0.55)], axis=1))
    start = rest(ROBOT, jnp.asarray(0.3), jnp.asarray(0.3), jnp.asarray(0.55))
    run = jax.jit(closed_loop)(ROBOT, start, published_pd(), reference=reference)
    position = np.asarray(run.states.position)
    error = np.linalg.norm(pose(position) - np.asarray(reference), axis=1)
    # Reported: 50 mm and 3.2 degrees, which it comes near at 2 s a leg.
    assert error.max() < 0.030
    assert np.rad2deg(np.abs(position[:, TILT]).max()) < 2.0


def test_height_of_section_2_1_would_make_a_plate_of_a_third_of_a_millimetre():
    half = 0.287e-3 / 2
    thin = replace(ROBOT, {"lower_offset": half, "upper_offset": half})
    # Eq. (1) would then have 87 % of the frame's area, and the paper's figure 65 %.
    assert frame_share(thin) > 0.87
    assert abs(float(frame_share(ROBOT)) - 0.651) <= 0.0005


def test_printed_modulus_would_stretch_the_loop_by_half_a_metre():
    printed = 350 / float(loop_stiffness(ROBOT, published_section()))
    used = 350 / float(loop_stiffness(ROBOT, consistent_section()))
    # To the digits given, 0.44 m and 4.4 mm.
    assert abs(printed - 0.44) <= 0.005
    assert abs(used - 4.4e-3) <= 0.05e-3


def test_staircase_finds_the_step_above_half_a_step_too_high():
    step = 0.1
    force = np.random.default_rng(0).uniform(0.4, 0.9, 10_000)
    found = step * np.ceil(force / step)
    # The mean of ten thousand evenly spread remainders.
    assert abs(np.mean(found - force) - step / 2) <= 4 * step / np.sqrt(12 * 10_000)


def test_weight_costs_the_printed_controller_three_millimetres():
    controller, drive = published_pd(), ROBOT.drive
    weight = float(ROBOT.end_effector.mass) * 9.81
    # Half of the weight's torque on each drive, of opposite signs.
    angle = weight * RADIUS / 2 / float(drive.torque_per_volt * controller.proportional_gain)
    assert abs(angle * RADIUS - 3.1e-3) <= 0.05e-3


def test_four_cables_have_one_self_balancing_family_of_tensions():
    pose = jnp.array([0.8, 0.5, 0.0])
    structure = jax.jacobian(
        lambda at: cable_lengths(
            ROBOT, at, end_effector_width=jnp.asarray(0.287), crossed=False
        )
    )(pose)
    cables, freedoms = structure.shape
    redundancy = cables - int(jnp.linalg.matrix_rank(structure))
    assert redundancy == cables - freedoms == 1


def test_every_test_that_the_errata_name_exists():
    text = (ROOT / "docs" / "errata.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(test_\w+)\.py::(test_\w+)`", text))
    sources = {
        path.stem: path.read_text(encoding="utf-8") for path in ROOT.glob("tests/**/test_*.py")
    }
    missing = [
        f"{module}::{test}"
        for module, test in sorted(named)
        if f"def {test}(" not in sources.get(module, "")
    ]
    assert named
    assert not missing
