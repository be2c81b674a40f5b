import jax
import numpy as np
import pytest

from scdpr_jax.numerics.side_by_side import kind_of, side_by_side

_square = jax.jit(lambda lanes: {"square": lanes["x"] ** 2, "twice": 2 * lanes["y"]})


@pytest.mark.parametrize("count", [1, 4, 5, 23])
def test_any_number_of_lanes_comes_back_in_order(count):
    lanes = {"x": np.arange(count, dtype=float), "y": np.ones((count, 3))}
    found = side_by_side(_square, lanes, size=4, program="square")
    np.testing.assert_array_equal(found["square"], lanes["x"] ** 2)
    np.testing.assert_array_equal(found["twice"], 2 * lanes["y"])


def test_every_chunk_has_the_same_size():
    sizes = set()

    def note(lanes):
        sizes.add(len(lanes))
        return lanes

    side_by_side(note, np.arange(10.0), size=4, program="note")
    assert sizes == {4}


def test_an_error_of_a_chunk_is_the_callers():
    def fail(lanes):
        raise FloatingPointError("no number")

    with pytest.raises(FloatingPointError, match="no number"):
        side_by_side(fail, np.arange(3.0), size=2, program="fail")


def test_kinds_differ_by_shape_type_and_what_is_no_array():
    kinds = {
        kind_of((np.zeros(2), "a")),
        kind_of((np.zeros(3), "a")),
        kind_of((np.zeros(2, np.float32), "a")),
        kind_of((np.zeros(2), "b")),
    }
    assert len(kinds) == 4
