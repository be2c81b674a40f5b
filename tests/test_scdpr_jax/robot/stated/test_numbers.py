"""The prototype's numbers: one for each quantity that campaigns can state."""

import math

from scdpr_jax.robot.stated.names import QUANTITIES
from scdpr_jax.robot.stated.numbers import GEARBOX, PROVENANCE, TORQUE_CONSTANT


def test_every_stated_quantity_has_its_numbers_and_where_they_come_from():
    assert [row.name for row in PROVENANCE] == [known.name for known in QUANTITIES]
    assert all(row.provenance for row in PROVENANCE)


def test_numbers_are_what_their_quantity_allows():
    for row, known in zip(PROVENANCE, QUANTITIES, strict=True):
        for number in (row.published, row.consistent):
            assert math.isfinite(number)
            assert number > 0 or (number == 0 and not known.positive)


def test_the_printed_torque_of_a_volt_is_the_nameplates_chain():
    [torque] = [row for row in PROVENANCE if row.name == "torque_per_volt"]
    assert torque.published == 0.6 * TORQUE_CONSTANT * GEARBOX
