"""The robot's named quantities: names, units, and what replacing them touches."""

import dataclasses

import equinox as eqx
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st

from scdpr_jax.robot.prototype import consistent, published
from scdpr_jax.robot.quantities import QUANTITIES, quantity, replace, value

ROBOT_KEYS = (
    "frame_width",
    "frame_height",
    "end_effector_mass",
    "end_effector_inertia",
    "lower_offset",
    "upper_offset",
    "lower_carriage_mass",
    "upper_carriage_mass",
    "friction_coefficient",
    "effective_pretension",
    "effective_radius",
    "drive_inertia",
    "drive_damping",
    "drive_friction",
    "torque_per_volt",
    "voltage_limit",
)
"""The keys of `[robot]` in format 1."""


def leaves_differing(first, second):
    pairs = zip(jax.tree.leaves(first), jax.tree.leaves(second), strict=True)
    return sum(bool(jnp.any(a != b)) for a, b in pairs)


def test_quantities_are_the_robot_keys_of_format_1():
    assert tuple(quantity.name for quantity in QUANTITIES) == ROBOT_KEYS


@hypothesis.given(name=st.sampled_from(ROBOT_KEYS), number=st.floats(1e-6, 1e6))
def test_replaced_value_is_read_back(name, number):
    assert value(replace(consistent(), {name: number}), name) == number


@pytest.mark.parametrize("name", ROBOT_KEYS)
def test_replacing_touches_the_quantitys_leaves_and_no_other(name):
    robot = consistent()
    replaced = replace(robot, {name: float(value(robot, name)) + 1})
    assert leaves_differing(robot, replaced) == len(quantity(name).leaves(robot))


@pytest.mark.parametrize("name", ROBOT_KEYS)
def test_a_quantitys_unit_and_symbol_are_its_fields(name):
    robot = consistent()
    target = quantity(name).leaves(robot)[0]
    parts = [robot.frame, robot.end_effector, robot.lower_carriage, robot.upper_carriage]
    parts += [robot.cable, robot.drive, robot.lower_carriage.friction]
    fields = [(part, field) for part in parts for field in dataclasses.fields(part)]
    found = [field for part, field in fields if getattr(part, field.name) is target]
    assert quantity(name).unit in {field.metadata["unit"] for field in found}


def test_unknown_name_is_told_the_known_ones():
    with pytest.raises(ValueError, match=r"'friction'.*friction_coefficient"):
        replace(consistent(), {"friction": 1.0})


def test_friction_coefficient_is_that_of_both_carriages():
    robot = replace(consistent(), {"friction_coefficient": 0.3})
    assert robot.lower_carriage.friction.coefficient == 0.3
    assert robot.upper_carriage.friction.coefficient == 0.3


def test_replacing_works_on_traced_values():
    slope = jax.jit(
        jax.grad(
            lambda T: (
                value(
                    replace(consistent(), {"effective_pretension": T}), "effective_pretension"
                )
                ** 2
            )
        )
    )
    assert slope(jnp.asarray(85.0)) == 170.0


def test_second_call_with_another_robot_does_not_recompile():
    traced = []

    @jax.jit
    def pretension(robot):
        traced.append(robot)
        return robot.cable.effective_pretension

    pretension(consistent())
    pretension(replace(published(), {"drive_damping": 3}))
    assert len(traced) == 1


def test_robots_batch_over_any_leaf():
    batch = eqx.filter_vmap(lambda T: replace(consistent(), {"effective_pretension": T}))(
        jnp.array([100.0, 200.0])
    )
    assert np.array_equal(value(batch, "effective_pretension"), [100.0, 200.0])


def test_a_refinement_outlasts_the_quantity_that_it_refines():
    both = {"upper_friction_coefficient": 0.1, "friction_coefficient": 0.2}
    robot = replace(consistent(), both)
    assert value(robot, "friction_coefficient") == 0.2
    assert value(robot, "upper_friction_coefficient") == 0.1
