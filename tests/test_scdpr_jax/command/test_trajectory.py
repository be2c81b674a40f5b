import math
import pathlib

import equinox as eqx
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.command.trajectory import (
    MINIMUM_JERK,
    QUARTIC,
    BezierLeg,
    Manoeuvre,
    rest_to_rest,
    table_3,
)
from scdpr_jax.robot.kinematics import inverse_kinematics

CAMPAIGNS = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "campaigns"
START, END = jnp.array([0.3, 0.55]), jnp.array([1.9, 0.75])
LEG = rest_to_rest(START, END, duration=2.0)
TABLE = table_3()
RIG = table_3(start_time=0.2, leg_times=(2.0, 2.25, 2.5))
EPS = float(jnp.finfo(START.dtype).eps)


@eqx.filter_jit
def position(trajectory, times):
    return jax.vmap(trajectory.position)(times)


@eqx.filter_jit
def velocity(trajectory, times):
    return jax.vmap(trajectory.velocity)(times)


@eqx.filter_jit
def acceleration(trajectory, times):
    return jax.vmap(trajectory.acceleration)(times)


@hypothesis.given(share=st.floats(0, 1))
def test_quartic_leg_is_the_cubic_smoothstep(share):
    got = position(LEG, jnp.array([2.0 * share]))[0]
    expected = START + (3 * share**2 - 2 * share**3) * (END - START)
    # Some twenty roundings of numbers up to 2 m.
    assert jnp.max(jnp.abs(got - expected)) <= 40 * EPS


@hypothesis.settings(max_examples=20)  # each order compiles anew
@hypothesis.given(
    share=st.floats(0, 1), order=st.sampled_from([1, 4, 9]), seed=st.integers(0, 100)
)
def test_bezier_leg_is_its_bernstein_sum(share, order, seed):
    points = np.random.default_rng(seed).uniform(0, 2, (order + 1, 2))
    weights = [
        math.comb(order, i) * share**i * (1 - share) ** (order - i) for i in range(order + 1)
    ]
    got = BezierLeg(points, 1.5).position(jnp.asarray(1.5 * share))
    # 1.5 s / 1.5 rounds the parameter; its derivative is at most order * 2 m.
    assert np.max(np.abs(np.asarray(got) - np.array(weights) @ points)) <= 40 * EPS * order


def test_leg_holds_its_ends_exactly():
    held = position(LEG, jnp.array([-1.0, 0.0, 2.0, 7.0]))
    assert jnp.array_equal(held, jnp.stack([START, START, END, END]))


@pytest.mark.parametrize("profile", [QUARTIC, MINIMUM_JERK])
def test_leg_starts_and_ends_at_rest(profile):
    leg = rest_to_rest(START, END, duration=2.0, profile=profile)
    speed = velocity(leg, jnp.array([-1.0, 0.0, 2.0, 3.0]))
    # The last point's derivative is a difference of equal control points.
    assert jnp.max(jnp.abs(speed)) <= 8 * EPS


def test_quartic_leg_accelerates_by_six_distances_over_its_time_squared():
    ends = acceleration(LEG, jnp.array([0.0, 2.0]))
    expected = 6 * (END - START) / 2.0**2
    # A handful of roundings of 2.4 m/s².
    assert jnp.max(jnp.abs(ends - jnp.stack([expected, -expected]))) <= 64 * EPS


def test_minimum_jerk_leg_starts_and_ends_without_acceleration():
    leg = rest_to_rest(START, END, duration=2.0, profile=MINIMUM_JERK)
    # Differences of equal control points, times twenty, over four.
    assert jnp.max(jnp.abs(acceleration(leg, jnp.array([0.0, 2.0])))) <= 64 * EPS


def test_velocity_integrates_to_the_distance():
    nodes, weights = np.polynomial.legendre.leggauss(4)  # exact for the velocity's quadratic
    speed = velocity(LEG, jnp.asarray(1.0 + nodes))
    distance = jnp.asarray(weights) @ speed
    assert jnp.max(jnp.abs(distance - (END - START))) <= 40 * EPS


def test_manoeuvre_goes_out_and_comes_back():
    got = position(TABLE.horizontal, jnp.array([0.0, 2.0, 4.0, 6.0, 8.0, 20.0]))
    expected = jnp.array([0.3, 1.1, 1.9, 1.1, 0.3, 0.3])
    assert jnp.max(jnp.abs(got[:, 0] - expected)) <= 16 * EPS
    assert jnp.max(jnp.abs(got[:, 1] - 0.55)) <= 16 * EPS


def test_manoeuvre_waits_for_its_start_time():
    late, early = RIG.diagonal, TABLE.diagonal
    times = jnp.linspace(-1.0, 10.0, 50)
    # A time of up to 10 s rounds before it is shifted; the speed is below 1 m/s.
    difference = position(late, times + 0.2) - position(early, times)
    assert jnp.max(jnp.abs(difference)) <= 8 * EPS * 10


def test_manoeuvre_duration_is_the_last_arrival():
    assert jnp.allclose(RIG.diagonal.duration, 5.2, rtol=4 * EPS, atol=0)


def test_acceleration_at_the_turn_is_that_of_one_leg():
    turn = acceleration(TABLE.horizontal, jnp.array([4.0]))[0]
    expected = jnp.array([-6 * 1.6 / 4.0**2, 0.0])
    assert jnp.max(jnp.abs(turn - expected)) <= 64 * EPS


def test_diagonal_asks_for_ten_volts_at_mid_leg_when_its_time_is_one_leg():
    # Steady speed at V volts: k_v V = b dalpha/dt, with the consistent prototype's numbers.
    mid_leg = velocity(TABLE.diagonal, jnp.array([1.25]))[0]
    voltage = inverse_kinematics(mid_leg, jnp.asarray(0.073)) * 0.2124 / 0.482
    # 10.1 V is given with three digits.
    assert abs(float(jnp.max(jnp.abs(voltage))) - 10.1) <= 0.05


def test_diagonal_would_need_twenty_volts_when_its_time_were_both_legs():
    halved = table_3(leg_times=(2.0, 2.25, 1.25)).diagonal
    voltage = inverse_kinematics(velocity(halved, jnp.array([0.625]))[0], jnp.asarray(0.073))
    assert jnp.max(jnp.abs(voltage)) * 0.2124 / 0.482 > 20


@pytest.mark.parametrize(
    ("run", "name"), [("0005-manoeuvre", "horizontal"), ("0006-manoeuvre", "vertical")]
)
def test_campaign_reference_is_table_3_at_half_its_times(run, name):
    path = CAMPAIGNS / "rig-b" / run / "drive.csv"
    if not path.exists():
        pytest.skip("the shared campaigns are not beside this repository")
    log = np.genfromtxt(path, delimiter=",", names=True)
    reference = np.stack([log["x_ref_m"], log["y_ref_m"]], axis=1)
    difference = position(getattr(RIG, name), jnp.asarray(log["t_s"])) - reference
    # Half a unit of the sixth decimal that is printed.
    assert np.max(np.abs(difference)) <= 0.5e-6 + 1e-12


def test_legs_that_do_not_join_are_refused():
    away = rest_to_rest(END + 0.1, START, duration=1.0)
    with pytest.raises(ValueError, match="leg 2 of a manoeuvre must start where leg 1 ends"):
        Manoeuvre((LEG, away))


def test_a_leg_of_no_duration_is_refused_and_leads_nowhere_under_jit():
    with pytest.raises(ValueError, match="`duration` of a leg must be positive"):
        rest_to_rest(START, END, duration=0.0)
    build = jax.jit(lambda time: rest_to_rest(START, END, duration=time).position(time))
    assert jnp.all(jnp.isnan(build(jnp.asarray(0.0))))


def test_a_manoeuvre_without_legs_is_refused():
    with pytest.raises(ValueError, match="at least one leg"):
        Manoeuvre(())


def test_a_profile_that_starts_moving_is_refused():
    with pytest.raises(ValueError, match="must start with 0, 0"):
        rest_to_rest(START, END, duration=1.0, profile=(0.0, 0.2, 0.8, 1.0))


@pytest.mark.slow
def test_manoeuvre_is_differentiable_in_time_points_and_duration():
    def at(times, start, end, duration):
        out = rest_to_rest(start, end, duration=duration)
        back = rest_to_rest(end, start, duration=duration)
        return jax.vmap(Manoeuvre((out, back)).position)(times)

    arguments = (jnp.array([0.7, 2.6]), START, END, jnp.asarray(2.0))
    check_grads(jax.jit(at), arguments, order=1, modes=("fwd", "rev"))


def test_manoeuvres_batch_over_their_leg_time():
    def peak(duration):
        return table_3(leg_times=(duration, 4.5, 2.5)).horizontal.velocity(duration / 2)[0]

    times = jnp.array([1.0, 2.0, 4.0])
    speeds = jax.jit(jax.vmap(peak))(times)
    # A quartic's peak is one and a half times its mean speed.
    assert jnp.max(jnp.abs(speeds - 1.5 * 1.6 / times)) <= 32 * EPS
