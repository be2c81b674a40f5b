"""The prototype's numbers: where they come from, and what they can do."""

import pytest

from scdpr_jax.robot.prototype import PROVENANCE, consistent, published
from scdpr_jax.robot.quantities import QUANTITIES, value


def test_provenance_has_each_quantity_once():
    assert tuple(source.name for source in PROVENANCE) == tuple(q.name for q in QUANTITIES)


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
