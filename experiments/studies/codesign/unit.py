"""A unit of a co-design: a search from one start, wherever it is asked for."""

import dataclasses
import functools
from collections.abc import Callable

import jax
import jax.numpy as jnp

from experiments.runtime.parcel import Parcel, packed, unpacked
from experiments.runtime.tree_parcel import tree_arrays, tree_of
from scdpr_jax.command.controller import published_pd
from scdpr_jax.legs.measures import LegMeasures
from scdpr_jax.robot.prototype import consistent
from tuning.codesign.designed import Designed
from tuning.codesign.models import models
from tuning.codesign.search import Search, Start
from tuning.codesign.shaped_legs import unshaped
from tuning.loop.admissible import any_bounds

_SOUGHT, _LAW = "sought", "law"


def parcel(search: Search) -> Parcel:
    """What is sought as plain data.

    Args:
        search: What is sought.

    Returns:
        The parcel.
    """
    arrays = tree_arrays(_SOUGHT, (search.models, search.within), _sought())
    return Parcel({"longest": search.longest}, arrays)


def payload(start: Start) -> bytes:
    """What a search is given by itself.

    Args:
        start: Where it starts.

    Returns:
        The start, packed.
    """
    return packed(Parcel({"move_time": start.move_time}, {"point": start.point}))


def designed_of(content: bytes) -> Designed:
    """The design that a search ended in.

    Args:
        content: The unit's result.

    Returns:
        The design.
    """
    facts, arrays = unpacked(content)
    measures = {own.name: arrays[own.name] for own in dataclasses.fields(LegMeasures)}
    return Designed(
        jax.tree.map(jnp.asarray, tree_of(_LAW, arrays, _law())),
        facts["move_time"],
        arrays["costs"],
        LegMeasures(**measures),
        arrays["point"],
    )


def begin(given: Parcel) -> Callable[[int, bytes], bytes]:
    """What searches from the starts of a co-design.

    Args:
        given: What is sought.

    Returns:
        From a start to the design that its search ends in, both packed.
    """
    seen, within = tree_of(_SOUGHT, given.arrays, _sought())
    search = Search(seen, jax.tree.map(jnp.asarray, within), given.facts["longest"])

    def computed(number: int, payload: bytes) -> bytes:
        facts, arrays = unpacked(payload)
        return _packed(search.design(Start(arrays["point"], facts["move_time"])))

    return computed


def _packed(design: Designed) -> bytes:
    fields = dataclasses.fields(LegMeasures)
    arrays = {
        **tree_arrays(_LAW, design.law, _law()),
        **{own.name: getattr(design.measures, own.name) for own in fields},
        "costs": design.costs,
        "point": design.point,
    }
    return packed(Parcel({"move_time": design.move_time}, arrays))


@functools.cache
def _sought() -> jax.tree_util.PyTreeDef:
    robot = consistent()
    seen = models([robot], begin=0.3, ends=(1.9,), heights=(0.55,))
    return jax.tree.structure((seen, any_bounds(robot)))


@functools.cache
def _law() -> jax.tree_util.PyTreeDef:
    return jax.tree.structure(unshaped(published_pd(), move_time=2.0))
