import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.shaper import ShapedTrajectory, Shaper
from scdpr_jax.command.trajectory import rest_to_rest
from scdpr_jax.legs.command_law import CommandLaw, unshaped

LEG = rest_to_rest((0.5, 0.4), (0.9, 0.6), duration=0.5)
SHAPER = Shaper([0.0, 0.15], [0.6, 0.4])


def test_a_law_commands_the_shaped_reference():
    commands = CommandLaw(LEG, published_pd(), SHAPER).commands(900)
    time = 1e-3 * jnp.arange(900.0)
    shaped = jax.vmap(ShapedTrajectory(LEG, SHAPER).position)(time)
    np.testing.assert_allclose(commands.commanded, shaped, atol=1e-15)
    np.testing.assert_allclose(commands.reference, jax.vmap(LEG.position)(time), atol=1e-15)


def test_without_a_shaper_both_references_are_the_same():
    commands = CommandLaw(LEG, published_pd()).commands(700)
    np.testing.assert_allclose(commands.commanded, commands.reference, atol=1e-15)
    assert float(unshaped().duration) == 0


def test_idle_impulses_change_nothing():
    few, many = (
        CommandLaw(LEG, published_pd(), unshaped(n)).commands(700).commanded for n in (1, 4)
    )
    np.testing.assert_allclose(few, many, atol=1e-15)


@pytest.mark.parametrize("judged", [None, 100])
def test_rest_is_judged_from_the_shaped_references_end_on(judged):
    law = CommandLaw(LEG, published_pd(), SHAPER)
    afterwards = np.flatnonzero(law.commands(900, judged=judged).afterwards)
    assert afterwards[0] == 650
    assert afterwards[-1] == (899 if judged is None else 749)
    assert np.all(np.diff(afterwards) == 1)
