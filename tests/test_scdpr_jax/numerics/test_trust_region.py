"""Steps within a trust region on a kinked problem whose linear model is solved exactly."""

import hypothesis
import hypothesis.strategies as st
import numpy as np

from scdpr_jax.numerics.trust_region import TrustRegion, descend


def value_of(place):
    """A kink at 1 with another slope on each of its sides, and a curve that bends both."""
    return max(2 * (1 - place), place - 1) + 0.1 * (place - 1) ** 2


def step(place, value, move):
    # The linear model is least at the kink, or as far towards it as the move allows.
    candidate = place + float(np.clip(1.0 - place, -move, move))
    return candidate, value_of(candidate)


@hypothesis.given(st.floats(-3.0, 5.0))
def test_a_minimum_on_a_kink_is_reached_to_the_last_move(start):
    place, value = descend(step, start, value_of(start), region=TrustRegion(steps=60))
    assert abs(place - 1.0) < 1e-6
    assert value == value_of(place)


@hypothesis.given(st.floats(-3.0, 5.0), st.integers(0, 6))
def test_the_value_never_rises(start, steps):
    def misled(place, value, move):
        candidate = place + move
        return candidate, value_of(candidate)

    before = value_of(start)
    _, value = descend(misled, start, before, region=TrustRegion(steps=steps))
    assert value <= before


def test_moves_double_where_they_help_and_shrink_to_a_quarter_where_not():
    moves = []

    def noted(place, value, move):
        moves.append(move)
        helped = len(moves) <= 2
        return place, value / 2 if helped else value

    descend(noted, 0.0, 1.0, region=TrustRegion(steps=5, first=1.0))
    assert moves == [1.0, 2.0, 4.0, 1.0, 0.25]


def test_it_ends_with_moves_that_lead_nowhere():
    moves = []

    def hopeless(place, value, move):
        moves.append(move)
        return place, value

    descend(hopeless, 0.0, 1.0, region=TrustRegion(steps=100, first=1.0, least=0.01))
    assert min(moves) >= 0.01
    assert len(moves) == 4


def test_it_ends_with_a_step_that_isn_t_worthwhile():
    tries = []

    def slow(place, value, move):
        tries.append(move)
        return place, value * 0.999

    descend(slow, 0.0, 1.0, region=TrustRegion(steps=100, worthwhile=0.01))
    assert len(tries) == 1


def test_nothing_left_is_nothing_to_do():
    def never(place, value, move):
        raise AssertionError("no step was needed")

    assert descend(never, 0.0, 0.0, region=TrustRegion(steps=3)) == (0.0, 0.0)
