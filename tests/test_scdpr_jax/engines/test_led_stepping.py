"""The undriven coordinates while lower carriage and height are led."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax import native
from scdpr_jax.contacts import single
from scdpr_jax.contacts.polynomial import Cubic, Quadratic
from scdpr_jax.engines.led_stepping import Lead, Undriven, step
from scdpr_jax.robot.dynamics import energy
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from scdpr_jax.robot.state import State

ROBOT = exact(replace(consistent(), {"friction_coefficient": 0.012}))
FREE = exact(replace(consistent(), {"friction_coefficient": 0.0}))
START = Undriven(jnp.asarray([0.5, 0.0, 0.5]), jnp.zeros(3))
DURATION = 1.5


def advance(given, state, lead):
    robot, duration = given
    following = step(robot, state, lead, duration)
    return following, following


def way(share):
    """A move and back of the lower carriage, and a lift."""
    return 0.5 + 0.3 * jnp.sin(jnp.pi * share) ** 2, 0.4 + 0.1 * share


def rows(lead, shares):
    lower, height = (jnp.stack([x[:-1:2], x[1::2], x[2::2]], 1) for x in lead(shares))
    return Lead(lower, height)


def led(robot, steps, start=START, lead=way):
    shares = jnp.arange(2 * steps + 1) / (2 * steps)
    given = (robot, jnp.asarray(DURATION / steps))
    return native.run(advance, given, start, rows(lead, shares))


def test_the_method_is_of_fourth_order_through_stops_and_starts():
    ends = [np.asarray(led(ROBOT, steps)[0].position) for steps in (150, 300, 600, 4800)]
    errors = [np.max(np.abs(end - ends[-1])) for end in ends[:-1]]
    # At 10 ms; the paper's camera sees 0.19 mm.
    assert errors[0] < 0.1e-3
    # 16 for each halving; an event that falls into another step may cost some of it.
    assert errors[0] / errors[2] > 100


def test_without_friction_energy_is_kept_while_nothing_leads():
    start = Undriven(jnp.asarray([0.53, 0.05, 0.46]), jnp.zeros(3))
    still = led(FREE, 600, start, lambda s: (0.5 + 0 * s, 0.4 + 0 * s))[1]

    def total(own):
        (x, tilt, upper), (v, w, u) = jnp.unstack(own.position), jnp.unstack(own.velocity)
        half, zero = jnp.asarray([0.5, 0.4]), jnp.zeros(())
        position = jnp.stack([x, tilt, half[0], upper, half[1]])
        return energy(FREE, State(position, jnp.stack([v, w, zero, u, zero])))

    first = total(start)
    rest = total(Undriven(jnp.asarray([0.5, 0.0, 0.5]), jnp.zeros(3)))
    every = jax.vmap(total)(still)
    assert np.max(np.abs(every - first)) < 1e-5 * float(first - rest)


def test_a_carriage_that_friction_holds_stands_still_to_the_bit():
    start = Undriven(jnp.asarray([0.5, 0.0, 0.5]), jnp.zeros(3))
    held = led(ROBOT, 100, start, lambda s: (0.5 + 0.002 * s, 0.4 + 0 * s))[1]
    assert np.all(np.asarray(held.velocity[:, 2]) == 0)
    assert np.all(np.asarray(held.position[:, 2]) == 0.5)


@pytest.mark.slow
def test_derivatives_hold_through_stops_and_starts():
    def end(size):
        def lead(share):
            lower, height = way(share)
            return 0.5 + size * (lower - 0.5), height

        shares = jnp.arange(601) / 600
        given = (ROBOT, jnp.asarray(DURATION / 300))
        return native.run(advance, given, START, rows(lead, shares))[0].position

    size = jnp.asarray(1.1)
    slope = jax.jit(jax.jacfwd(end))(size)
    ahead, behind = (jax.jit(end)(size + h) for h in (1e-6, -1e-6))
    np.testing.assert_allclose(slope, (ahead - behind) / 2e-6, rtol=2e-4, atol=1e-6)


@pytest.mark.parametrize(
    ("branch", "velocity", "load", "leaves"),
    [
        (1.0, (0.1, -0.05, 0.0), (0.0, 0.0, 0.0), False),
        (1.0, (0.1, -0.3, 0.0), (0.0, 0.0, 0.0), True),
        (0.0, (0.0, 0.0, 0.0), (0.0, 0.5, 0.0), False),
        (0.0, (0.0, 0.0, 0.0), (0.0, 1.5, 0.0), True),
    ],
)
def test_a_carriage_leaves_its_branch_where_it_stops_or_breaks_away(
    branch, velocity, load, leaves
):
    assumed = single.Assumed(
        branch=jnp.asarray(branch),
        velocity=Cubic(Quadratic(*map(jnp.asarray, velocity)), jnp.zeros(())),
        load=Quadratic(*map(jnp.asarray, load)),
        limit=jnp.asarray(1.0),
        stiffness=jnp.zeros(()),
    )
    assert bool(single.leaves(assumed)) is leaves
    if not leaves:
        assert not any(map(bool, single.deviation(assumed).moments))
