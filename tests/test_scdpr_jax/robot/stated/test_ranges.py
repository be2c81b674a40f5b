"""What a robot's numbers can be: every known rig is within, slips of a unit are not."""

import math

import pytest

from scdpr_jax.robot.stated.names import EVERY_QUANTITY, QUANTITIES
from scdpr_jax.robot.stated.numbers import PROVENANCE
from scdpr_jax.robot.stated.ranges import check_robot, check_value, limits


@pytest.mark.parametrize("column", ["published", "consistent"])
def test_the_papers_robot_can_be(column):
    check_robot({row.name: getattr(row, column) for row in PROVENANCE})


@pytest.mark.parametrize("kind", EVERY_QUANTITY, ids=lambda kind: kind.name)
def test_a_quantity_is_within_its_limits_and_nowhere_else(kind):
    least, most = limits(kind)
    assert (least < 0) == kind.signed
    assert (least == 0) == (not kind.positive and not kind.signed)
    for inside in (least, most):
        check_value(kind.name, inside)
    outside = (math.nextafter(least, -math.inf), math.nextafter(most, math.inf))
    for number in (*outside, math.nan, math.inf, -math.inf):
        with pytest.raises(
            ValueError, match=rf"`{kind.name}` can't be a robot's, got .*expected"
        ):
            check_value(kind.name, number)


def test_a_part_that_does_not_fit_into_the_frame_is_refused():
    values = {row.name: row.consistent for row in PROVENANCE}
    for name in ("upper_offset", "effective_radius"):
        with pytest.raises(
            ValueError, match=rf"`{name}` can't be .*less than the `frame_height`"
        ):
            check_robot(values | {name: values["frame_height"]})


def test_what_is_not_there_is_not_checked():
    check_robot({known.name: 1.0 for known in QUANTITIES if known.name != "frame_height"})
