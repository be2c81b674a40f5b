"""python-control's plant and controller against our responses and our controller."""

import sys

import control
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tunings import NAMES, TUNINGS

from tuning.export.description import describe
from tuning.export.python_control import control_objects
from tuning.loop.plant import continuous_response
from tuning.loop.responses import sampled_derivative


@pytest.fixture(params=TUNINGS, ids=NAMES)
def tuning(request):
    return request.param


def test_the_plant_is_the_continuous_one_of_equation_24(tuning):
    frequencies = np.geomspace(0.1, 1e3, 40)
    respond = jax.jit(jax.vmap(lambda w: continuous_response(describe(tuning).plant, w)))
    expected = np.asarray(respond(jnp.asarray(frequencies)))
    found = control_objects(tuning).plant(1j * frequencies)
    assert np.max(np.abs(found / expected - 1)) <= 1e-14


def test_the_controller_has_the_sampled_pds_response(tuning):
    pd = tuning.controller
    frequencies = np.geomspace(0.1, 0.99 * np.pi / float(pd.period), 40)

    def derivative(w):
        return sampled_derivative(w, period=pd.period, filter_time=pd.filter_time)

    rate = np.asarray(jax.jit(jax.vmap(derivative))(jnp.asarray(frequencies)))
    expected = float(pd.proportional_gain) + float(pd.derivative_gain) * rate
    found = control_objects(tuning).controller(np.exp(1j * frequencies * float(pd.period)))
    # Its polynomials cancel the derivative, K_d / h, against itself at low frequency.
    size = float(pd.proportional_gain) + float(pd.derivative_gain) / float(pd.period)
    assert np.max(np.abs(found - expected)) <= 16 * np.finfo(float).eps * size


def test_the_controller_answers_errors_as_the_pd_does(tuning):
    pd = tuning.controller
    # From rest: python-control's system knows no sample before its first.
    errors = np.random.default_rng(6).normal(0, 0.01, (200, 2))
    errors[0] = 0.0

    @jax.jit
    def ours(errors):
        zero = jnp.zeros(2)
        start = pd.initial_state(errors[0], zero)
        return jax.lax.scan(lambda state, now: pd.step(state, now, zero), start, errors)[1]

    expected = np.asarray(ours(jnp.asarray(errors)))
    times = float(pd.period) * np.arange(200)
    for axis in range(2):
        found = control.forced_response(
            control_objects(tuning).controller, times, errors[:, axis]
        )
        # Commands reach 100 V here: 1e-12 of that.
        assert np.max(np.abs(found.outputs - expected[:, axis])) <= 1e-10


def test_without_python_control_the_extra_is_named(tuning, monkeypatch):
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(ImportError, match=r"scdpr-jax\[control\]"):
        control_objects(tuning)
