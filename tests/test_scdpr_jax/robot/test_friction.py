import equinox as eqx
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st
from jax.test_util import check_grads

from scdpr_jax.robot.friction import Coulomb, SmoothCoulomb

EPS = float(np.finfo(float).eps)
RISE = {"static_surplus": 0.01, "stribeck_velocity": 0.01}
LAWS = (
    Coulomb(0.02, 1.5),
    SmoothCoulomb(0.02, 1e-3, 1.5),
    Coulomb(0.02, **RISE),
    SmoothCoulomb(0.02, 1e-3, **RISE),
)
NAMES = ("exact", "smoothed", "exact with a rise", "smoothed with a rise")
every_law = pytest.mark.parametrize("law", LAWS, ids=NAMES)
speed = st.floats(-2, 2)
normal = st.floats(1.0, 2e3)


@jax.jit
def dry(law, velocity, normal_force):
    return law.dry(velocity, normal_force)


def force(law, velocity, normal_force):
    return float(dry(law, jnp.asarray(velocity), jnp.asarray(normal_force)))


@every_law
@hypothesis.given(speed, normal)
def test_dry_friction_never_gives_power(law, velocity, normal_force):
    assert force(law, velocity, normal_force) * velocity >= 0


@every_law
@hypothesis.given(speed, normal)
def test_dry_friction_is_odd_in_the_velocity(law, velocity, normal_force):
    assert force(law, -velocity, normal_force) == -force(law, velocity, normal_force)


@every_law
@hypothesis.given(speed, normal)
def test_dry_friction_is_proportional_to_the_normal_force(law, velocity, normal_force):
    # Doubling is exact in binary floating point.
    assert force(law, velocity, 2 * normal_force) == 2 * force(law, velocity, normal_force)


@every_law
def test_dry_friction_vanishes_at_standstill(law):
    assert force(law, 0.0, 300.0) == 0


@hypothesis.given(st.floats(1e-6, 2), normal)
def test_sliding_coulomb_friction_is_the_coefficient_times_the_normal_force(
    speed, normal_force
):
    assert abs(force(LAWS[0], speed, normal_force) - 0.02 * normal_force) <= (
        2 * EPS * normal_force
    )


@hypothesis.given(st.floats(0.02, 2), normal)
def test_smoothed_friction_is_exact_beyond_twenty_widths(speed, normal_force):
    # tanh(20) differs from 1 by 9e-18, below a rounding.
    assert force(LAWS[1], speed, normal_force) == force(LAWS[0], speed, normal_force)


def test_smoothed_friction_has_its_documented_slope_at_standstill():
    slope = jax.grad(lambda v: LAWS[1].dry(v, jnp.asarray(300.0)))(jnp.asarray(0.0))
    assert jnp.allclose(slope, 0.02 * 300.0 / 1e-3, rtol=4 * EPS, atol=0)


@pytest.mark.parametrize("law", LAWS[2:], ids=NAMES[2:])
@hypothesis.given(st.floats(1e-2, 0.05))
def test_friction_falls_from_static_to_kinetic(law, speed):
    expected = 0.02 + 0.01 * np.exp(-((speed / 0.01) ** 2))
    # From ten widths on tanh differs from 1 by less than 4e-9.
    assert abs(force(law, speed, 1.0) - expected) <= 5e-9 * expected
    assert float(law.sliding(jnp.asarray(0.0))) == pytest.approx(0.03, rel=1e-12)


@pytest.mark.parametrize("law", LAWS[1::2], ids=NAMES[1::2])
def test_smooth_laws_are_differentiable_at_standstill_too(law):
    # Velocities in widths, so that the checker's own difference step resolves the law.
    def along(scale, widths):
        scaled = jax.tree.map(lambda leaf: leaf * scale, law)
        return jax.vmap(lambda v: scaled.dry(v, jnp.asarray(300.0)))(1e-3 * widths)

    arguments = (jnp.asarray(1.0), jnp.array([0.0, 0.2, -10.0]))
    check_grads(jax.jit(along), arguments, order=1, modes=("fwd", "rev"))


@pytest.mark.parametrize("mode", [jax.jacfwd, jax.jacrev])
def test_coulomb_friction_has_its_derivative_in_the_coefficient(mode):
    def of_coefficient(coefficient):
        return Coulomb(coefficient).dry(jnp.asarray(-0.3), jnp.asarray(300.0))

    assert jax.jit(mode(of_coefficient))(jnp.asarray(0.02)) == -300.0


@every_law
@hypothesis.given(st.floats(0, 10))
def test_viscous_damping_is_not_part_of_the_dry_friction(law, viscous):
    damped = eqx.tree_at(lambda law: law.viscous, law, jnp.asarray(viscous))
    assert force(damped, 0.3, 200.0) == force(law, 0.3, 200.0)
