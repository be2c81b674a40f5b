"""A field's metadata is its unit and its symbol."""

import dataclasses

import pytest

from scdpr_jax.robot.parameters import Cable, Carriage, Drive, EndEffector, Frame
from scdpr_jax.robot.stated.units import si


def test_unit_and_symbol_are_kept_apart():
    assert si("kg m^2", "J") == {"unit": "kg m^2", "symbol": "J"}
    assert si("1") == {"unit": "1", "symbol": ""}


@pytest.mark.parametrize("part", [Frame, EndEffector, Carriage, Cable, Drive])
def test_every_number_of_a_robot_states_its_unit(part):
    numbers = [field for field in dataclasses.fields(part) if field.name != "friction"]
    if part is Drive:
        numbers = list(dataclasses.fields(part))
    assert all(field.metadata["unit"] for field in numbers)
