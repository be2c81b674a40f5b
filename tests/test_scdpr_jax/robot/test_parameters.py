import dataclasses
import json
import subprocess
import sys

import equinox as eqx
import hypothesis
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import strategies as st

from scdpr_jax.robot.friction import Coulomb, SmoothCoulomb
from scdpr_jax.robot.parameters import QUANTITIES, exact, quantity, replace, smoothed, value
from scdpr_jax.robot.prototype import PROVENANCE, consistent, published

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

IMPORT_ALL = """
import importlib, json, pkgutil, sys
import jax
before = dict(jax.config.values)
import scdpr_jax
for module in pkgutil.iter_modules(scdpr_jax.__path__):
    importlib.import_module("scdpr_jax." + module.name)
after = dict(jax.config.values)
changed = [name for name in after if after[name] != before.get(name)]
edges = [name for name in ("pint", "matplotlib", "rich", "scipy.io") if name in sys.modules]
print(json.dumps({"changed": changed, "edges": edges}))
"""


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


def test_provenance_has_each_quantity_once():
    assert tuple(source.name for source in PROVENANCE) == ROBOT_KEYS


@pytest.mark.parametrize("source", PROVENANCE, ids=lambda source: source.name)
def test_both_prototypes_carry_their_provenance(source):
    assert value(published(), source.name) == source.published
    assert value(consistent(), source.name) == source.consistent


def test_prototypes_differ_only_where_the_paper_contradicts_itself():
    differing = {source.name for source in PROVENANCE if source.published != source.consistent}
    assert differing == {
        "friction_coefficient",
        "effective_pretension",
        "effective_radius",
        "drive_damping",
        "torque_per_volt",
    }


def test_published_radius_cannot_run_the_diagonal_manoeuvre_and_the_consistent_can():
    # Speed at full voltage, r k_v V / b; the diagonal's peak is 1.5 times 2.07 m in 2.5 s.
    def top_speed(robot):
        drive = robot.drive
        angular = drive.torque_per_volt * drive.voltage_limit / drive.damping
        return drive.effective_radius * angular

    assert top_speed(published()) < 1.5 * 2.07 / 2.5 < top_speed(consistent())


def test_every_field_of_the_robot_has_its_unit():
    def units(part):
        for field in dataclasses.fields(part):
            child = getattr(part, field.name)
            if isinstance(child, eqx.Module):
                yield from units(child)
            else:
                yield field.metadata.get("unit", "")

    assert all(units(smoothed(consistent())))


def test_integers_become_floating_leaves():
    assert all(
        jnp.issubdtype(leaf.dtype, jnp.floating) for leaf in jax.tree.leaves(Coulomb(1, 2))
    )


def test_smoothing_keeps_coefficients_and_damping():
    robot = eqx.tree_at(
        lambda r: r.upper_carriage.friction, consistent(), Coulomb(0.4, viscous=2.0)
    )
    law = smoothed(robot, width=2e-3).upper_carriage.friction
    assert isinstance(law, SmoothCoulomb)
    assert (law.coefficient, law.width, law.viscous) == (0.4, 2e-3, 2.0)


def test_exact_undoes_smoothing():
    robot = consistent()
    assert eqx.tree_equal(exact(smoothed(robot)), robot)


@pytest.mark.parametrize("width", [0.0, -1e-3, float("nan")])
def test_smoothing_asks_for_a_positive_width(width):
    with pytest.raises(ValueError, match=r"positive \[m/s\], got"):
        smoothed(consistent(), width=width)


def test_robots_batch_over_any_leaf():
    batch = eqx.filter_vmap(lambda T: replace(consistent(), {"effective_pretension": T}))(
        jnp.array([100.0, 200.0])
    )
    assert np.array_equal(value(batch, "effective_pretension"), [100.0, 200.0])


@pytest.fixture(scope="module")
def fresh_import():
    ran = subprocess.run(
        [sys.executable, "-W", "error", "-c", IMPORT_ALL], capture_output=True, text=True
    )
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def test_importing_changes_no_jax_configuration(fresh_import):
    assert fresh_import["changed"] == []


def test_importing_brings_in_no_package_of_the_edges(fresh_import):
    assert fresh_import["edges"] == []
