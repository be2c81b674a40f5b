"""What only a branch needs is done there, and nothing else is moved."""

import jax
import jax.numpy as jnp
import numpy as np
from equinox.internal import unvmap_any
from scalar_functions import by_llvm, read_function

from scdpr_jax.native.scalar.program import If, operations
from scdpr_jax.native.scalar.sinking import sunk

LANES = 4
POINTS = np.random.default_rng(4).uniform(-1, 1, (LANES, 3))


def branching(x):
    rare, common = jnp.exp(x) * jnp.sin(x), x * x
    last = jax.lax.cond(
        unvmap_any(x[0] > 2), lambda a, b: a + b, lambda a, b: b, jnp.tan(rare), common
    )
    return last + common


def test_what_only_a_branch_needs_is_done_there():
    program = sunk(read_function(branching, jnp.zeros(3)))
    (branch,) = (own for own in program.body if isinstance(own, If))
    before = [own.name for own in operations(program.body[: program.body.index(branch)])]
    inside = [own.name for own in operations(branch.then)]
    assert not {"exp", "sin", "tan"} & {*before}
    assert [inside.count(name) for name in ("exp", "sin", "tan")] == [3, 3, 3]
    assert not {"exp", "sin", "tan"} & {own.name for own in operations(branch.otherwise)}
    assert before.count("mul") == 3


def test_it_does_the_same_on_either_way():
    program = read_function(branching, jnp.zeros(3))
    for points in (POINTS, POINTS + 3):
        ways = (by_llvm(own, lanes=LANES)([points])[0] for own in (program, sunk(program)))
        np.testing.assert_array_equal(*ways)
