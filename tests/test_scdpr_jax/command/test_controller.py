import pathlib

import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.command.controller import PD, published_pd, saturate
from scdpr_jax.robot.kinematics import inverse_kinematics

CAMPAIGNS = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "campaigns"
ZERO = jnp.zeros(2)
LIMIT = jnp.asarray(10.0)


@jax.jit
def commands(controller, references, measured):
    def step(state, sample):
        return controller.step(state, *sample)

    state = controller.initial_state(references[0], measured[0])
    return jax.lax.scan(step, state, (references, measured))[1]


def test_published_gains_act_on_degrees():
    controller = published_pd()
    error = jnp.deg2rad(jnp.array([1.0, -2.0]))
    _, voltage = controller.step(controller.initial_state(error, ZERO), error, ZERO)
    # 0.6352 V for each degree, up to three roundings.
    assert jnp.allclose(voltage, jnp.array([0.6352, -1.2704]), rtol=1e-15, atol=0)


def test_derivative_of_a_ramp_is_its_slope():
    controller = PD(0.0, 3.0, period=1e-3)
    times = 1e-3 * jnp.arange(10.0)
    ramp = jnp.stack([2.0 * times, -1.0 * times], axis=1)
    voltage = commands(controller, ramp, jnp.zeros_like(ramp))
    # One ulp of 0.02 rad over the period, times the gain.
    tolerance = 3.0 * 0.02 * jnp.finfo(ramp.dtype).eps / 1e-3
    assert jnp.max(jnp.abs(voltage[1:] - jnp.array([[6.0, -3.0]]))) <= tolerance


def test_first_sample_has_no_derivative_kick():
    controller = PD(2.0, 5.0)
    error = jnp.array([0.1, 0.3])
    _, voltage = controller.step(controller.initial_state(error, ZERO), error, ZERO)
    assert jnp.array_equal(voltage, 2.0 * error)


@hypothesis.given(filter_time=st.floats(1e-4, 0.1))
def test_filtered_derivative_of_a_step_decays_by_its_closed_form(filter_time):
    period, count = 1e-3, 20
    controller = PD(0.0, 1.0, period, filter_time)
    step = jnp.ones((count + 1, 2)).at[0].set(0.0)
    voltage = commands(controller, step, jnp.zeros_like(step))[1:, 0]
    ratio = filter_time / (filter_time + period)
    expected = ratio ** np.arange(count) / (filter_time + period)
    # Twenty products of one rounding each.
    tolerance = 4 * count * float(jnp.finfo(step.dtype).eps) / period
    assert np.max(np.abs(np.asarray(voltage) - expected)) <= tolerance


def test_filter_tames_encoder_quantisation():
    count = 2 * jnp.pi / 26624
    angles = count * jnp.round(0.05 * 1e-3 * jnp.arange(2000.0) / count)
    measured = jnp.stack([angles, angles], axis=1)

    def scatter(filter_time):
        controller = PD(0.0, 1.0, 1e-3, filter_time)
        return jnp.std(commands(controller, jnp.zeros_like(measured), measured)[500:])

    # White differences through a first-order low-pass of ten periods lose a factor of
    # sqrt(1 / (2 * 10 + 1)) at least.
    assert scatter(10e-3) < scatter(0.0) / 4


@pytest.mark.parametrize("run", ["0005-manoeuvre", "0006-manoeuvre"])
def test_published_controller_replays_the_campaigns_voltages(run):
    path = CAMPAIGNS / "rig-b" / run / "drive.csv"
    if not path.exists():
        pytest.skip("the shared campaigns are not beside this repository")
    log = np.genfromtxt(path, delimiter=",", names=True)
    counts = np.stack([log["alpha_1_count"], log["alpha_2_count"]], axis=1)
    position = jnp.asarray(np.stack([log["x_ref_m"], log["y_ref_m"]], axis=1))
    to_angles = jax.vmap(inverse_kinematics, in_axes=(0, None))
    references = to_angles(position - position[:1], jnp.asarray(0.073))
    voltage = commands(published_pd(), references, jnp.asarray(counts * 2 * np.pi / 26624))
    logged = np.stack([log["voltage_1_V"], log["voltage_2_V"]], axis=1)
    # x_ref and y_ref are rounded to 1 um: each of two references in the difference of two
    # samples is off by up to 0.5 um, times K_d / h / r; K_p adds one of them, the log 0.5 mV.
    rounding = 2 * 0.5e-6 / 0.073 * (0.7162 * 2 / 1e-3 + 36.4) + 0.5e-3
    assert np.max(np.abs(np.asarray(voltage) - logged)) <= rounding


@hypothesis.given(first=st.floats(-30, 30), second=st.floats(-30, 30))
def test_saturation_is_the_exact_clip(first, second):
    voltage = jnp.array([first, second])
    assert jnp.array_equal(saturate(voltage, LIMIT), jnp.clip(voltage, -10.0, 10.0))


@pytest.mark.parametrize(
    ("voltage", "slope", "limit_slope"),
    [
        (3.0, 1.0, 0.0),
        (10.0, 1.0, 0.0),
        (-10.0, 1.0, 0.0),
        (11.0, 0.0, 1.0),
        (-11.0, 0.0, -1.0),
    ],
)
def test_saturation_has_its_documented_derivative(voltage, slope, limit_slope):
    slopes = jax.jit(jax.jacfwd(saturate, argnums=(0, 1)))(jnp.array([voltage, 0.0]), LIMIT)
    reverse = jax.jit(jax.jacrev(saturate, argnums=(0, 1)))(jnp.array([voltage, 0.0]), LIMIT)
    for in_voltage, in_limit in (slopes, reverse):
        assert (in_voltage[0, 0], in_limit[0]) == (slope, limit_slope)


def test_saturation_is_differentiable_away_from_the_limit():
    check_grads(jax.jit(saturate), (jnp.array([4.0, -13.0]), LIMIT), 2, modes=("fwd", "rev"))


def test_controller_is_differentiable_in_gains_filter_and_measurements():
    key = jax.random.key(0)
    references, measured = 0.1 * jax.random.normal(key, (2, 6, 2), dtype=float)

    def run(proportional, derivative, filter_time, measured):
        return commands(PD(proportional, derivative, 0.1, filter_time), references, measured)

    arguments = (jnp.asarray(36.0), jnp.asarray(0.7), jnp.asarray(0.2), measured)
    check_grads(jax.jit(run), arguments, order=1, modes=("fwd", "rev"))


def test_controllers_batch_over_their_gains():
    gains = jnp.array([10.0, 20.0])
    errors = jnp.ones((3, 2))
    batch = jax.vmap(lambda gain: commands(PD(gain, 0.0), errors, jnp.zeros_like(errors)))
    assert jnp.array_equal(jax.jit(batch)(gains)[:, 0, 0], gains)


def test_a_period_of_zero_is_refused_and_is_no_number_under_jit():
    with pytest.raises(ValueError, match="`period` of a controller must be positive"):
        PD(1.0, 1.0, 0.0)
    build = jax.jit(lambda period: PD(1.0, 1.0, period).period)
    assert jnp.isnan(build(jnp.asarray(0.0)))
    assert build(jnp.asarray(1e-3)) == 1e-3
