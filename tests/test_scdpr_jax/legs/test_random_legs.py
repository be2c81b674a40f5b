import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scdpr_jax.legs.random_legs import OUT_OF_LINE, random_legs
from scdpr_jax.robot.prototype import consistent

FRAME = consistent().frame


@given(st.integers(0, 2**32 - 1))
def test_every_leg_lies_in_the_workspace_and_goes_somewhere(seed):
    legs = random_legs(FRAME, 50, seed=seed)
    places = np.stack([legs.start, legs.end])
    assert np.all(places >= (0.3 - 1e-12, 0.25 - 1e-12))
    assert np.all(places <= (1.9 + 1e-12, 0.85 + 1e-12))
    assert np.all(np.abs(legs.end - legs.start)[:, 0] >= 0.3 - 1e-12)
    assert np.all((legs.time >= 1.7) & (legs.time <= 4.0))


@given(st.floats(0.0, 2.0), st.floats(0.0, 1.0))
def test_legs_to_a_part_of_the_workspace_end_in_it(x, y):
    legs = random_legs(FRAME, 20, seed=3, x=(x, x + 0.2), y=(y, y + 0.1))
    low = np.clip((x, y), (0.3, 0.25), (1.9, 0.85))
    high = np.clip((x + 0.2, y + 0.1), (0.3, 0.25), (1.9, 0.85))
    assert np.all((legs.end >= low) & (legs.end <= high))
    assert np.all(np.abs(legs.end - legs.start)[:, 0] >= 0.3 - 1e-12)


def test_every_other_leg_starts_out_of_line():
    slopes = random_legs(FRAME, 40, seed=1).out_of_line
    assert np.all(slopes[::2] == 0)
    assert np.all(slopes[1::2] != 0)
    assert np.abs(slopes).max() <= OUT_OF_LINE


def test_a_seed_draws_the_same_legs_again():
    first, second = (random_legs(FRAME, 5, seed=7) for _ in range(2))
    np.testing.assert_array_equal(first.end, second.end)
    np.testing.assert_array_equal(first.start, second.start)
