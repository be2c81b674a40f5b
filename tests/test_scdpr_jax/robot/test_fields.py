"""Fields that know their unit, and numbers as a person reads them."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.robot.fields import concrete, measured, real, refuse
from scdpr_jax.robot.friction import Coulomb


def test_integers_become_floating_leaves():
    assert all(
        jnp.issubdtype(leaf.dtype, jnp.floating) for leaf in jax.tree.leaves(Coulomb(1, 2))
    )


@pytest.mark.parametrize("number", [np.float32(1.5), jnp.asarray(1.5, dtype=jnp.float32)])
def test_floating_numbers_keep_their_precision(number):
    assert real(number).dtype == jnp.float32


@pytest.mark.parametrize("number", [1, True, 2.0, [1, 2], np.arange(3)])
def test_real_numbers_have_the_default_precision_and_are_not_weak(number):
    array = real(number)
    assert array.dtype == jnp.asarray(0.0).dtype
    assert not array.weak_type


def test_a_number_is_shown_with_its_unit():
    assert measured(jnp.asarray(85.0), "N") == "85 N"
    assert measured(jnp.asarray(0.0132352), "1") == "0.01324"


def test_an_array_and_a_traced_number_are_shown_as_their_shape():
    shown = []
    jax.eval_shape(lambda number: shown.append(measured(number, "N")), jnp.asarray(1.0))
    assert measured(jnp.ones(3), "N") == eqx.tree_pformat(jnp.ones(3)) + " N"
    assert shown == [eqx.tree_pformat(jnp.asarray(1.0)) + " N"]


def test_what_is_refused_raises_where_it_is_known_and_is_no_number_where_it_is_traced():
    def positive(number):
        return refuse({"number": number}, ~(concrete(number) > 0), "must be positive")["number"]

    assert positive(jnp.array(2.0)) == 2.0
    with pytest.raises(ValueError, match="must be positive"):
        positive(jnp.array(-2.0))
    each = jax.vmap(positive)(jnp.array([-2.0, 3.0]))
    assert jnp.isnan(each[0])
    assert each[1] == 3.0
    assert jax.grad(jax.jit(lambda x: positive(x) ** 2))(3.0) == 6.0
