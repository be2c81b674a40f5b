import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
from short_runs import bare_run

from identification.data.circumstances import NAMES
from identification.fit.unknowns.unknowns import (
    DEFAULT_FREE,
    apply,
    decode,
    encode,
    layout,
    start_values,
)
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import value


def test_every_setting_has_its_own_pretension():
    runs = [bare_run("torque_step", 200.0), bare_run("torque_step", 500.0)]
    unknowns = layout(runs, DEFAULT_FREE)
    assert [s for n, s in unknowns.shared if n == "effective_pretension"] == ["200 N", "500 N"]
    own = DEFAULT_FREE.index("effective_pretension")
    assert unknowns.local[0][own] != unknowns.local[1][own]
    others = [k for k in range(len(DEFAULT_FREE)) if k != own]
    np.testing.assert_array_equal(unknowns.local[0][others], unknowns.local[1][others])


def test_only_what_a_run_leaves_open_is_estimated_of_it():
    runs = [bare_run("torque_step"), bare_run("pseudo_impulse"), bare_run("motor_step")]
    active = layout(runs, DEFAULT_FREE).active
    np.testing.assert_array_equal(active[0], [True] * 3 + [False] * 4)
    np.testing.assert_array_equal(active[1], [True] * 5 + [False] * 2)
    np.testing.assert_array_equal(active[2], [False] * 7)


def test_a_clock_drifts_only_where_asked_and_only_one_that_there_is():
    blind = dataclasses.replace(bare_run("torque_step"), camera=None)
    runs = [bare_run("torque_step"), blind, bare_run("motor_step")]
    active = layout(runs, DEFAULT_FREE, clock_drifts=True).active
    np.testing.assert_array_equal(active[:, -1], [runs[0].camera is not None, False, False])


def test_a_robots_own_values_come_back_from_a_fits_vector():
    robot = consistent()
    unknowns = layout([bare_run("torque_step")], DEFAULT_FREE)
    same = apply(robot, DEFAULT_FREE, jnp.asarray(start_values(robot, unknowns)))
    for name in DEFAULT_FREE:
        # The exponential of a logarithm: a few roundings of numbers up to ln 85.
        np.testing.assert_allclose(value(same, name), value(robot, name), rtol=1e-14)


@pytest.mark.parametrize(
    ("name", "number"), [("drive_inertia", 0.01), ("friction_coefficient", 0.0)]
)
def test_decoding_undoes_encoding(name, number):
    np.testing.assert_allclose(decode(name, encode(name, number)), number, rtol=1e-14)


def test_an_unknown_name_is_refused():
    with pytest.raises(ValueError, match="unknown quantity 'friction'"):
        layout([bare_run("torque_step")], ("friction",))


def test_a_name_given_twice_is_refused():
    with pytest.raises(ValueError, match="twice"):
        layout([bare_run("torque_step")], ("drive_inertia", "drive_inertia"))


def test_every_unknown_has_a_place_of_its_own():
    runs = [bare_run("torque_step", 200.0), bare_run("pseudo_impulse", 500.0)]
    unknowns = layout(runs, DEFAULT_FREE)
    shared = [unknowns.place(name, setting) for name, setting in unknowns.shared]
    circumstances = [unknowns.circumstance(run, name) for run in (0, 1) for name in NAMES]
    assert sorted([*shared, *circumstances]) == list(range(unknowns.size))


def test_a_fit_of_some_runs_leaves_the_others_circumstances_alone():
    runs = [bare_run("torque_step"), bare_run("pseudo_impulse")]
    unknowns = layout(runs, DEFAULT_FREE, opened=DEFAULT_FREE[:2])
    is_open = unknowns.open_to([1])
    assert np.flatnonzero(is_open[: len(unknowns.shared)]).tolist() == [0, 1]
    assert not np.any(is_open[unknowns.circumstances(0)])
    np.testing.assert_array_equal(is_open[unknowns.circumstances(1)], unknowns.active[1])
