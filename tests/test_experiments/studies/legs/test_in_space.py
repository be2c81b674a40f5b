import dataclasses

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest
from report_samples import tracking_run

from experiments.studies.legs.in_space import in_space


def late(samples):
    """A run that does exactly what it is told, by so many samples later."""
    run = tracking_run(swing=0.0)
    before = np.maximum(np.arange(200) - samples, 0)
    states = dataclasses.replace(run.states, position=run.states.position[before])
    return dataclasses.replace(run, states=states)


@hypothesis.given(samples=st.integers(0, 90))
def test_a_run_that_is_only_late_is_nowhere_off(samples):
    placed = in_space(late(samples))
    assert placed.lag == pytest.approx(0.01 * samples, abs=1e-12)
    # The same numbers, moved.
    assert placed.distance.max() == 0


def test_what_is_off_in_space_stays():
    placed = in_space(tracking_run(swing=0.02))
    assert placed.arrival == pytest.approx(1.0, abs=1e-12)
    # It swings by 20 mm about the target once it has arrived.
    late_enough = placed.time > placed.arrival
    assert np.ptp(placed.off[late_enough, 0]) == pytest.approx(0.04, rel=0.02)
    assert np.allclose(placed.distance, np.abs(placed.off[:, 0]))
