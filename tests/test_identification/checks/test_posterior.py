"""The posterior of the drives alone: a problem small enough to be sampled in a test."""

import dataclasses
import importlib.util

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from experiments.virtual_rig.recovery import campaign, draw
from identification.checks import posterior as module
from identification.checks.posterior import posterior, require_numpyro
from identification.fit.unknowns.measured import MeasuredQuantity
from identification.fit.unknowns.options import FitOptions
from identification.result.estimation import estimate, solved
from scdpr_jax.robot.quantities import replace

FREE = ("drive_inertia", "drive_damping", "drive_friction")


@pytest.fixture(scope="module")
def logs():
    """A step of drives whose dry friction is far from zero: the misfit is a parabola."""
    truth = draw(3)
    whole = campaign(truth._replace(robot=replace(truth.robot, {"drive_friction": 0.05})), 3)
    return dataclasses.replace(whole, runs=(whole.run("0004-motor-step"),))


@pytest.fixture(scope="module")
def found(logs):
    damping = MeasuredQuantity(quantity="drive_damping", value=0.2636, sigma=1e-4)
    return estimate(logs, FitOptions(free=FREE, measured=[damping]))


@pytest.fixture(scope="module")
def drawn(logs, found):
    return posterior(logs, found, seed=1)


@pytest.mark.slow
def test_the_potential_is_half_of_the_misfit_and_its_derivative_that_of_the_fit(logs, found):
    problem, point = solved(logs, found)
    near = point.copy()
    near[: len(FREE)] *= 1 + 1e-5
    half, slope = jax.value_and_grad(lambda x: module._half_misfit(problem, x))(
        jnp.asarray(near)
    )
    (normal,) = problem.evaluate([near])
    assert float(half) == pytest.approx(normal.cost / 2, rel=1e-12)
    np.testing.assert_allclose(slope, normal.gradient, rtol=1e-9, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", FREE)
def test_where_the_misfit_is_a_parabola_the_posterior_is_the_fit(found, drawn, name):
    (fitted,) = (p for p in found.parameters if p.name == name)
    own = drawn.draws[:, :, [n for n, _ in drawn.names].index(name)]
    # 400 independent draws: means to 0.05, spreads to 0.035 standard errors, four of them.
    assert abs(own.mean() - fitted.value) < 0.2 * fitted.sigma
    assert own.std() == pytest.approx(fitted.sigma, rel=0.14)


def test_what_can_t_be_negative_is_reflected(logs, found):
    sampled = module._Sampled(*solved(logs, found))
    far = 1e6 * jax.random.normal(jax.random.key(0), (50, sampled.at.size))
    held = np.asarray(jax.vmap(sampled.values)(far))
    friction = FREE.index("drive_friction")
    assert held[:, friction].min() >= 0
    assert np.any(held[:, 0] < 0)


@pytest.mark.slow
def test_the_chains_agree(drawn):
    assert np.all(drawn.r_hat <= module.APART)
    assert np.all(drawn.effective >= module.ENOUGH)


@pytest.mark.slow
def test_an_interval_holds_its_share_of_the_draws(drawn):
    low, high = drawn.interval(0.9).T
    inside = (drawn.draws >= low) & (drawn.draws <= high)
    np.testing.assert_allclose(inside.mean(axis=(0, 1)), 0.9, atol=0.01)


@pytest.mark.slow
def test_chains_that_don_t_agree_are_refused(logs, found, monkeypatch):
    monkeypatch.setattr(module, "APART", 0.0)
    monkeypatch.setattr(module, "ROUNDS", 1)
    with pytest.raises(FloatingPointError, match="chains don't agree after 50 draws"):
        posterior(logs, found)


def test_without_its_library_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ValueError, match=r"scdpr-jax\[bayes\]"):
        require_numpyro()
