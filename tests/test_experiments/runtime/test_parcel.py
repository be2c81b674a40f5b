"""Plain data on their way: the same when they arrive, and nothing else is taken for them."""

import hypothesis
import hypothesis.extra.numpy as hnp
import numpy as np
import pytest
from hypothesis import strategies as st

from experiments.runtime.parcel import Parcel, packed, unpacked

facts = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.text() | st.floats(width=32),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)
RECORD = np.dtype([("a", np.float64, (2, 3)), ("b", np.bool_), ("c", np.float32)])
kinds = st.sampled_from([np.dtype(k) for k in ("f8", "f4", "i8", "u1", "?")] + [RECORD])
arrays = st.dictionaries(
    st.text(), hnp.arrays(kinds, hnp.array_shapes(min_dims=0, min_side=0)), max_size=3
)


@hypothesis.given(facts=st.dictionaries(st.text(), facts, max_size=3), arrays=arrays)
@hypothesis.settings(max_examples=60)
def test_what_is_packed_is_unpacked_to_the_same_bits(facts, arrays):
    content = packed(Parcel(facts, arrays))
    found = unpacked(content)
    assert packed(found) == content
    assert [*found.arrays] == [*arrays]
    for name, array in arrays.items():
        assert found.arrays[name].dtype == array.dtype
        assert found.arrays[name].shape == array.shape
        assert found.arrays[name].tobytes() == array.tobytes()


@pytest.mark.parametrize("cut", [1, 8, 40, 90])
def test_a_parcel_that_was_cut_is_none(cut):
    content = packed(Parcel({"a": 1}, {"b": np.arange(4.0)}))
    with pytest.raises(ValueError, match=r"parcel|JSON|Unterminated|Expecting|delimiter|value"):
        unpacked(content[:-cut])


def test_a_parcel_with_more_behind_it_is_none():
    with pytest.raises(ValueError, match="1 bytes too many"):
        unpacked(packed(Parcel({})) + b"!")


def test_no_object_comes_out_of_a_parcel():
    content = packed(Parcel({}, {"a": np.zeros(1)})).replace(b'"<f8"', b'"|O" ')
    with pytest.raises(ValueError, match="isn't of numbers"):
        unpacked(content)
