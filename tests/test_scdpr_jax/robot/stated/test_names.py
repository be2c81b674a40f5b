"""Every named quantity stands somewhere in a robot, once."""

import jax
import pytest

from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.stated.names import EVERY_QUANTITY, QUANTITIES, quantity


@pytest.mark.parametrize("known", EVERY_QUANTITY, ids=lambda known: known.name)
def test_its_leaves_are_a_robots(known):
    robot = consistent()
    leaves = {id(leaf) for leaf in jax.tree.leaves(robot)}
    assert known.leaves(robot)
    assert all(id(leaf) in leaves for leaf in known.leaves(robot))


def test_no_name_stands_twice_and_each_is_found():
    names = [known.name for known in EVERY_QUANTITY]
    assert len(set(names)) == len(names)
    assert [quantity(name) for name in names] == list(EVERY_QUANTITY)


def test_no_two_quantities_read_the_same_leaf():
    robot = consistent()
    first = [id(known.leaves(robot)[0]) for known in QUANTITIES]
    assert len(set(first)) == len(first)


def test_an_unknown_name_is_told_with_those_that_there_are():
    with pytest.raises(ValueError, match="unknown quantity 'mass', expected one of: frame_"):
        quantity("mass")
