"""Knocks that ring otherwise than their pretension's label says."""

import dataclasses

import jax.numpy as jnp
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from identification.knocks.frequency_map import FrequencyMap
from identification.knocks.settings import alike_settings, odd_knocks
from scdpr_jax.linear.modes import BOTH_HELD, natural_frequencies
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace

HEIGHTS = (0.55, 0.55, 0.86, 0.30)


def rung(*tensions, labels, scatter=0.0, seed=0):
    """A map of four knocks at each of some effective tensions, under some labels."""
    random = np.random.default_rng(seed)
    frequencies = []
    for tension in tensions:
        robot = replace(consistent(), {"effective_pretension": tension})
        for height in HEIGHTS:
            lowest = natural_frequencies(robot, jnp.asarray(height), BOTH_HELD)[0]
            frequencies.append(float(lowest) * np.exp(scatter * random.normal()))
    count = len(frequencies)
    whole = np.full(count, 0.01)
    return FrequencyMap(
        x=np.full(count, 1.1),
        y=np.tile(HEIGHTS, len(tensions)),
        pretension=np.repeat(labels, len(HEIGHTS)).astype(float),
        frequency=np.array(frequencies),
        frequency_sigma=whole,
        damping_ratio=whole,
        damping_ratio_sigma=whole,
        fft_frequency=np.array(frequencies),
        residuals_are_noise=np.ones(count, dtype=bool),
        runs=tuple(f"{k + 1:04d}-pseudo-impulse" for k in range(count)),
    )


@given(
    first=st.floats(60.0, 120.0),
    growth=st.floats(1.3, 2.0),
    seed=st.integers(0, 1000),
)
def test_settings_that_differ_are_not_remarked_on(first, growth, seed):
    knocks = rung(first, first * growth, labels=[200, 200 * growth], scatter=0.015, seed=seed)
    assert alike_settings(knocks, consistent()) == ()
    assert odd_knocks(knocks, consistent()) == ()


def test_two_settings_that_ring_alike_are_told():
    (pair,) = alike_settings(rung(85.0, 86.0, labels=[200, 350]), consistent())
    assert pair.settings == (200.0, 350.0)
    assert 1.0 < pair.ratio < 1.05


def test_a_knock_under_another_settings_label_is_told_with_that_setting():
    knocks = rung(60.0, 105.0, labels=[200, 350])
    label = knocks.pretension.copy()
    label[2] = 350.0
    (odd,) = odd_knocks(dataclasses.replace(knocks, pretension=label), consistent())
    assert odd.setting == 350.0
    assert odd.runs == ("0003-pseudo-impulse",)
    assert odd.rings_as == 200.0
    assert odd.ratio < 0.7


def test_of_two_knocks_that_differ_both_are_named():
    knocks = rung(60.0, 105.0, labels=[350, 350])
    two = [0, 4]
    columns = {
        field.name: getattr(knocks, field.name)[two]
        for field in dataclasses.fields(knocks)
        if isinstance(getattr(knocks, field.name), np.ndarray)
    }
    pair = dataclasses.replace(knocks, runs=("0001", "0005"), **columns)
    (odd,) = odd_knocks(pair, consistent())
    assert odd.runs == ("0001", "0005")
