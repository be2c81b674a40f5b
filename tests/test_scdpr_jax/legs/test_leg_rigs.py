"""The test rigs that legs are judged on, held against the engine and against themselves."""

import dataclasses

import jax.numpy as jnp
import leg_rigs
import numpy as np
import pytest

from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.sensors import Encoder
from scdpr_jax.engines.closed_loop import closed_loop
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import State

pytestmark = leg_rigs.needs_compiler
PLAIN = published_pd()
GAINS = float(PLAIN.proportional_gain), float(PLAIN.derivative_gain)
LEGS = leg_rigs.random_legs(3, 4)


def driven(rig, leg, **told):
    duration = leg.time + leg_rigs.HOLD
    reference = leg_rigs.pulleys(leg_rigs.plain_profile(leg, 1e-3, leg.time))
    start = leg_rigs.start_of(rig, leg)
    return leg_rigs.drive_leg(rig, start, reference, gains=GAINS, duration=duration, **told)


@pytest.mark.parametrize("leg", LEGS)
def test_a_rigid_rig_does_what_the_engine_does(leg):
    rig = leg_rigs.draw_rig(0, elastic=False)
    robot = replace(
        consistent(),
        {
            "effective_pretension": rig.pretension,
            "friction_coefficient": rig.lower_friction,
            "drive_inertia": rig.inertia,
            "drive_damping": rig.damping,
        },
    )
    start = jnp.asarray(leg_rigs.start_of(rig, leg))
    run = closed_loop(
        robot,
        State(start, jnp.zeros(5)),
        published_pd(),
        reference=jnp.asarray(leg_rigs.plain_profile(leg, 1e-3, leg.time + leg_rigs.HOLD)),
        encoder=Encoder(26624.0),
    )
    # Both step: 25 µs, and 1 ms of an engine of second order. Friction ends at other instants.
    error = np.abs(np.asarray(run.states.position) - driven(rig, leg).position).max(axis=0)
    assert error[[0, 2, 3, 4]].max() < 0.1e-3


def test_a_stiff_cable_without_play_makes_an_elastic_rig_a_rigid_one():
    rigid = leg_rigs.draw_rig(0, elastic=False)
    stiff = dataclasses.replace(rigid, cable_stiffness=1e6, cable_damping=100.0)
    for leg in LEGS:
        error = driven(stiff, leg).position[:, 0] - driven(rigid, leg).position[:, 0]
        assert np.abs(error).max() < 0.3e-3


def test_an_elastic_rig_is_off_the_rigid_one_by_a_millimetre():
    rig = leg_rigs.draw_rig(0, elastic=True)
    same = dict.fromkeys(
        ("loop_stiffness", "static_surplus", "motor_friction", "backlash", "ripple"), 0.0
    )
    rigid = dataclasses.replace(rig, cable_stiffness=np.inf, **same)
    error = driven(rig, LEGS[0]).position[:, 0] - driven(rigid, LEGS[0]).position[:, 0]
    assert np.abs(error).max() > 1e-3


def test_random_legs_are_the_same_for_a_seed_and_within_the_workspace():
    legs = leg_rigs.random_legs(5, 40)
    assert legs == leg_rigs.random_legs(5, 40)
    x, y = np.moveaxis(np.array([(leg.start, leg.end) for leg in legs]), 2, 0)
    assert x.min() >= 0.3
    assert x.max() <= 1.9
    assert y.min() >= 0.25
    assert y.max() <= 0.85
    assert np.abs(np.diff(x)).min() >= 0.3
    assert all(1.7 <= leg.time <= 4 for leg in legs)
    tilts = np.array([leg.tilt for leg in legs])
    assert np.all(tilts[::2] == 0)
    assert 0 < np.abs(tilts[1::2]).max() <= 0.8


def test_a_rig_rests_where_friction_holds_its_start():
    rig = leg_rigs.draw_rig(1, elastic=False)
    leg = leg_rigs.RandomLeg((1.0, 0.5), (1.0, 0.5), 1.0, 0.79)
    start = leg_rigs.start_of(rig, leg)
    still = leg_rigs.drive_leg(rig, start, np.zeros((1, 2)), gains=(0.0, 0.0), duration=0.5)
    assert np.abs(still.position - start).max() < 1e-9


@pytest.mark.parametrize("elastic", [False, True])
def test_a_logged_campaign_has_every_kind_of_run(elastic):
    campaign = leg_rigs.campaign(leg_rigs.draw_rig(2, elastic=elastic), 2)
    kinds = {run.kind for run in campaign.runs}
    assert kinds == {"torque_step", "manoeuvre", "pseudo_impulse", "breakaway", "motor_step"}
    for run in campaign.runs:
        assert np.isfinite(run.drive.angle).all()
        assert np.ptp(run.drive.angle) > 0
