"""The robot's parameters: units, friction laws, and what a person is shown."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import pytest

from scdpr_jax.robot.friction import Coulomb, SmoothCoulomb
from scdpr_jax.robot.parameters import exact, smoothed
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace


def test_every_field_of_the_robot_has_its_unit():
    def units(part):
        for field in dataclasses.fields(part):
            child = getattr(part, field.name)
            if isinstance(child, eqx.Module):
                yield from units(child)
            else:
                yield field.metadata.get("unit", "")

    assert all(units(smoothed(consistent())))


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


def test_a_robot_is_shown_in_a_few_lines_with_units():
    lines = repr(consistent()).splitlines()
    assert len(lines) <= 10
    assert "  cable: effective_pretension 85 N" in lines


def test_what_is_as_by_default_is_not_shown():
    plain, loop = consistent(), replace(consistent(), {"loop_stiffness": 2e3})
    assert "stiffness" not in repr(plain)
    assert "stiffness 2000 N/m" in repr(loop)


def test_batched_and_traced_robots_are_shown_too():
    shown = []
    jax.eval_shape(lambda robot: shown.append(repr(robot)), consistent())
    batch = jax.tree.map(lambda leaf: jnp.stack([leaf, leaf]), consistent())
    for text in (*shown, repr(batch)):
        assert text.startswith("Robot\n  frame: width f")
