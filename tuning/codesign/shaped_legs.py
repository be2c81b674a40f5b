"""The plain leg of section 6.2, shaped: what designs begin with, and are compared with."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.legs.command_law import unshaped as no_shaper
from scdpr_jax.linear.modes import held_frequency
from tuning.codesign.models import Models
from tuning.codesign.unknowns import IMPULSES, Law, plain_profile
from tuning.shapers.catalogue import CATALOGUE


def unshaped(controller: PD, *, move_time: float) -> Law:
    """A controller on the plain leg of section 6.2.

    Args:
        controller: The controller.
        move_time: Time of the leg [s].

    Returns:
        The law.
    """
    return shaped(controller, no_shaper(), move_time=move_time)


def shaped(controller: PD, shaper: Shaper, *, move_time: float) -> Law:
    """A controller on the plain leg of section 6.2, shaped, in the same time.

    Args:
        controller: The controller.
        shaper: The impulses, `IMPULSES` at the most, shorter than the move.
        move_time: Time of leg and shaper [s].

    Returns:
        The law.
    """
    idle = IMPULSES - shaper.times.size
    # As many for every shaper, so that what follows compiles once.
    whole = Shaper(
        jnp.concatenate([shaper.times, jnp.full(idle, shaper.times[-1])]),
        jnp.concatenate([shaper.amplitudes, jnp.zeros(idle)]),
    )
    return Law(
        controller,
        whole,
        jnp.asarray(plain_profile()),
        jnp.asarray(move_time) - shaper.duration,
    )


def references(models: Models, *, move_time: float) -> dict[str, Law]:
    """What a design is compared with: Eq. (25) as it is, and with a ZV shaper.

    Args:
        models: The models.
        move_time: Time of the move, the shaper included [s].

    Returns:
        The laws by name.
    """
    _, middle, _ = held_frequencies(models)
    zv = CATALOGUE[0].design(middle, 0.0)
    return {
        "Eq. (25)": unshaped(published_pd(), move_time=move_time),
        "Eq. (25) and ZV": shaped(published_pd(), zv, move_time=move_time),
    }


def held_frequencies(models: Models) -> tuple[float, float, float]:
    """Natural frequencies of the models while friction holds both carriages.

    Args:
        models: The models.

    Returns:
        The lowest, the median and the highest [Hz].
    """
    frequencies = _held(models)
    return (
        float(jnp.min(frequencies)),
        float(jnp.median(frequencies)),
        float(jnp.max(frequencies)),
    )


@jax.jit
def _held(models: Models) -> Float[Array, " n"]:
    return jax.vmap(lambda model: held_frequency(model.ensemble.robot, model.end[1]))(models)
